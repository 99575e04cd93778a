"""One scene through octant, and how far it is from what LAMMPS made of it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from validation import precisions, tolerances
from validation.check import Check
from validation.dumps import read_dump
from validation.logs import Run
from validation.octant_runner import OctantResult, count_neighbors, run_octant
from validation.reference import SceneReference, StaleReference, digest, neighbor_scripts, short_run
from validation.scene import Scene
from validation.scripts import Script


@dataclass
class SceneResult:
    """Everything compared about one scene."""

    name: str
    atoms: int = 0
    steps: int = 0
    #: Pairs in LAMMPS's list at the end of the run.
    pairs: int = 0
    checks: list[Check] = field(default_factory=list)
    #: Relative difference of each thermo column at each printed step: {column: [[Lennard-Jones time, difference], ..]}.
    deviations: dict[str, list[list[float]]] = field(default_factory=dict)
    lammps_loop_seconds: float = float("nan")
    octant_loop_seconds: float = float("nan")

    @property
    def passed(self) -> bool:
        return all(check.passed for check in self.checks)

    def check(self, name: str) -> Check | None:
        return next((check for check in self.checks if check.name == name), None)

    def as_json(self) -> dict[str, Any]:
        fields = {key: value for key, value in self.__dict__.items() if key != "checks"}
        return {**fields, "passed": self.passed, "checks": [check.as_json() for check in self.checks]}


def compare_scene(
    scene: Scene,
    reference: SceneReference,
    scratch: Path,
    *,
    backend: str = "cpu",
    among: Sequence[str] = precisions.ALL,
) -> SceneResult:
    """Runs one scene through octant, on ``backend`` in the precisions of ``among``, and compares with LAMMPS's side.

    ``scratch`` is a folder to make and remove. Raises StaleReference where LAMMPS ran another script, and OctantError.
    """
    if reference.digest != digest(scene):
        raise StaleReference(f"{scene.path.name} is not the script that LAMMPS ran: save the reference anew")
    result = SceneResult(scene.name, atoms=len(reference.frames[0].values), lammps_loop_seconds=reference.loop_seconds)
    steps = reference.run.column("Step")
    result.steps, result.pairs = int(steps[-1] - steps[0]), int(reference.run.statistics["pairs"])
    script = Script.read(scene.path)
    scratch.mkdir(parents=True)
    melted = scratch / "melted.data"
    melted.write_text(reference.melted, encoding="utf-8")
    shared = {**scene.variables, **reference.variables, "out": str(scratch)}
    forces = reference.frames[0]["fx fy fz"]

    # Neighbors of every atom at the start, and on the melted configuration that LAMMPS ended with.
    paths = neighbor_scripts(script, melted, scratch)
    theirs = (reference.start_neighbors, reference.melted_neighbors)
    for name, path, counts in zip(("at the start", "when melted"), paths, theirs, strict=True):
        ours = count_neighbors(path, shared, backend=backend)
        result.checks.append(compare_counts(f"neighbors {name}", ours, counts))

    for precision in among:
        # The scene as it stands; then forces on the melted atoms and, a few steps later, positions, every digit.
        whole = run_octant(scene.path, shared, precision=precision, backend=backend)
        dump = scratch / "full.dump"
        short = short_run(script, melted, dump, tolerances.SHORT_RUN if precision == "double" else 0)
        melt = run_octant(short.write(scratch / "short.in"), shared, precision=precision, backend=backend)
        frames = read_dump(dump)
        if precision == "double":
            result.octant_loop_seconds = whole.summary["timing"]["loop_s"]
            _compare_thermo(result, reference.run, whole, _timestep(script) / scene.lj_time)
            _compare_print(result, reference.printed, whole, 0.0 if scene.every_digit else float("inf"))
            _compare_lists(result, reference.run.statistics, whole)
            _compare_frames(result, reference.frames, frames)
        else:
            result.checks += precisions.compare(precision, frames[0]["fx fy fz"], forces, whole, reference.run)
            result.checks.append(precisions.compare_lists(precision, melt, reference.melted_neighbors))
    shutil.rmtree(scratch)
    return result


def _timestep(script: Script) -> float:
    """The timestep of a script that sets it at most once, time units."""
    defaults = {"lj": 0.005, "real": 1.0, "metal": 0.001, "si": 1e-8}
    words = {line.split()[0]: line.split()[1] for line in script.lines if line.split()[0] in ("units", "timestep")}
    return float(words["timestep"]) if "timestep" in words else defaults[words.get("units", "lj")]


def _compare_thermo(result: SceneResult, theirs: Run, octant: OctantResult, lj_times_per_step: float) -> None:
    """Every column of every printed row, full precision, then the rows as LAMMPS prints them."""
    printed, ours = octant.runs[-1], octant.summary["thermo"]
    if printed.columns != theirs.columns or [row["Step"] for row in ours] != [
        int(step) for step in theirs.column("Step")
    ]:
        detail = (
            f"columns {printed.columns}, LAMMPS has {theirs.columns}; {len(ours)} rows, LAMMPS has {len(theirs.rows)}"
        )
        result.checks.append(Check("thermo rows", float("inf"), 0.0, detail))
        return
    steps = np.array(theirs.column("Step"))
    times = (steps - steps[0]) * lj_times_per_step
    bounds = np.array([tolerances.thermo_bound(time, result.pairs) for time in times])
    for column in theirs.columns[1:]:
        reference = np.array(theirs.column(column))
        values = np.array([row[column] for row in ours], dtype=np.float64)
        scale = np.abs(reference).max() or 1.0
        difference = np.abs(values - reference) / scale
        result.deviations[column] = np.column_stack([times, difference]).tolist()
        detail = f"{difference[0]:.1e} at the first step, {difference[-1]:.1e} at the last (bound {bounds[-1]:.1e})"
        result.checks.append(Check(column, float((difference / bounds).max()), 1.0, detail))


def _compare_print(result: SceneResult, theirs: list[list[str]], octant: OctantResult, bound: float) -> None:
    """The rows of the two log files as text. A difference far below the bounds above can still turn a digit."""
    ours = octant.runs[-1].rows
    different = sum(a != b for a, b in zip(theirs, ours, strict=False)) + abs(len(theirs) - len(ours))
    result.checks.append(Check("rows that differ in print", different, bound, f"{len(theirs)} rows"))


def _compare_lists(result: SceneResult, theirs: Mapping[str, float], octant: OctantResult) -> None:
    """List length, builds and dangerous builds at the end of the run: equal."""
    ours = octant.summary["neighbors"]
    for name, key, reference in (
        ("list length", "total", theirs.get("pairs")),
        ("builds", "builds", theirs.get("builds")),
        ("dangerous builds", "dangerous", theirs.get("dangerous")),
    ):
        value = ours[key]
        if reference is None or value is None:
            # `check no`: neither program knows.
            difference = 0.0 if reference is value else float("inf")
            detail = "not checked" if reference is value else f"{value}, LAMMPS {reference}"
        else:
            difference, detail = abs(value - reference), f"{value:.0f}"
        result.checks.append(Check(name, difference, 0.0, detail))


def compare_counts(name: str, ours: NDArray[np.int64], theirs: NDArray[np.int64] | None) -> Check:
    if theirs is None or ours.shape != theirs.shape:
        shape = None if theirs is None else theirs.shape
        return Check(name, float("inf"), 0.0, f"{ours.shape} counts, LAMMPS has {shape}")
    return Check(
        name, int((ours != theirs).sum()), 0.0, f"{theirs.mean():.2f} an atom, {theirs.min()} to {theirs.max()}"
    )


def _compare_frames(result: SceneResult, theirs: list, ours: list) -> None:
    """Forces of the first frame, positions of the last."""
    if len(ours) != len(theirs) or (ours[0]["id"] != theirs[0]["id"]).any():
        result.checks.append(
            Check("full-precision dump", float("inf"), 0.0, f"{len(ours)} frames, LAMMPS has {len(theirs)}")
        )
        return
    force = theirs[0]["fx fy fz"]
    rms = float(np.sqrt((force**2).mean()))
    difference = ours[0]["fx fy fz"] - force
    result.checks.append(
        Check("forces, max", float(np.abs(difference).max() / rms), tolerances.FORCE_MAX.value, f"RMS force {rms:.4g}")
    )
    result.checks.append(Check("forces, RMS", float(np.sqrt((difference**2).mean()) / rms), tolerances.FORCE_RMS.value))
    moved = np.abs(ours[-1].displacement(theirs[-1])).max() / theirs[-1].lengths.max()
    detail = f"after {theirs[-1].step - theirs[0].step} steps"
    result.checks.append(Check("positions", float(moved), tolerances.POSITION.value, detail))
