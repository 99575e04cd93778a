"""One scene through both programs, and how far apart they are."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from validation import precisions, tolerances
from validation.check import Check
from validation.dumps import full_precision, read_dump
from validation.lammps_runner import LammpsResult, run_lammps
from validation.octant_runner import OctantResult, count_neighbors, run_octant
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


def compare_scene(scene: Scene, variables: Mapping[str, str | int], scratch: Path) -> SceneResult:
    """Runs one scene through both programs, with ``variables`` set; ``scratch`` is a folder to make and remove."""
    result = SceneResult(scene.name)
    script = Script.read(scene.path)
    shared = {**scene.variables, **variables}
    folders = {"lammps": scratch / "lammps", "octant": scratch / "octant"}
    for folder in folders.values():
        folder.mkdir(parents=True)

    # The scene as it stands.
    melted = scratch / "melted.data"
    for_lammps = (
        script.for_lammps().before_runs("thermo_modify format float %.17g").then(f"write_data {melted} nocoeff")
    )
    lammps = run_lammps(for_lammps.write(scratch / "scene.in"), {**shared, "out": str(folders["lammps"])})
    octant = run_octant(scene.path, {**shared, "out": str(folders["octant"])})
    result.atoms = octant.summary["atoms"]
    result.lammps_loop_seconds = lammps.loop_seconds
    result.octant_loop_seconds = octant.summary["timing"]["loop_s"]
    _compare_thermo(result, lammps, octant, _timestep(script) / scene.lj_time)
    plain = script.for_lammps().write(scratch / "plain.in")
    as_printed = run_lammps(plain, {**shared, "out": str(folders["lammps"])})
    _compare_print(result, as_printed, octant, 0.0 if scene.every_digit else float("inf"))
    _compare_lists(result, lammps, octant)

    # Neighbors of every atom at the start, and on the melted configuration that LAMMPS ended with.
    start = script.silent().until_run().write(scratch / "start.in")
    liquid = script.silent().from_data(melted).until_run()
    at_melted = liquid.write(scratch / "melted.in")
    for name, path in (("neighbors at the start", start), ("neighbors when melted", at_melted)):
        with_run = Script.read(path).then("run 0").write(path.with_suffix(".run.in"))
        ours = count_neighbors(with_run, shared)
        theirs = run_lammps(with_run, shared, neighbors=True).neighbors
        result.checks.append(compare_counts(name, ours, theirs))

    # Forces there and positions a few steps later, every digit.
    frames = {}
    for program, run in (("lammps", run_lammps), ("octant", run_octant)):
        dump = folders[program] / "full.dump"
        short = liquid.then(*full_precision(tolerances.SHORT_RUN, dump), f"run {tolerances.SHORT_RUN}")
        run(short.write(scratch / f"short.{program}.in"), shared)
        frames[program] = read_dump(dump)
    _compare_frames(result, frames["lammps"], frames["octant"])
    short = liquid.then(*full_precision(1, folders["octant"] / "fast.dump"), "run 0").write(scratch / "short.fast.in")
    for precision in ("mixed", "single"):
        at_once = run_octant(short, shared, precision=precision)
        forces = read_dump(folders["octant"] / "fast.dump")[0]["fx fy fz"]
        whole = run_octant(scene.path, {**shared, "out": str(folders["octant"])}, precision=precision)
        result.checks += precisions.compare(precision, forces, frames["lammps"][0]["fx fy fz"], whole, lammps)
        result.checks.append(precisions.compare_lists(precision, at_once, run_octant(short, shared)))
    shutil.rmtree(scratch)
    return result


def _timestep(script: Script) -> float:
    """The timestep of a script that sets it at most once, time units."""
    defaults = {"lj": 0.005, "real": 1.0, "metal": 0.001, "si": 1e-8}
    words = {line.split()[0]: line.split()[1] for line in script.lines if line.split()[0] in ("units", "timestep")}
    return float(words["timestep"]) if "timestep" in words else defaults[words.get("units", "lj")]


def _compare_thermo(result: SceneResult, lammps: LammpsResult, octant: OctantResult, lj_times_per_step: float) -> None:
    """Every column of every printed row, full precision, then the rows as LAMMPS prints them."""
    theirs, printed, ours = lammps.runs[-1], octant.runs[-1], octant.summary["thermo"]
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
    pairs = theirs.statistics["pairs"]
    bounds = np.array([tolerances.thermo_bound(time, pairs) for time in times])
    result.steps = int(steps[-1] - steps[0])
    result.pairs = int(pairs)
    for column in theirs.columns[1:]:
        reference = np.array(theirs.column(column))
        values = np.array([row[column] for row in ours], dtype=np.float64)
        scale = np.abs(reference).max() or 1.0
        difference = np.abs(values - reference) / scale
        result.deviations[column] = np.column_stack([times, difference]).tolist()
        detail = f"{difference[0]:.1e} at the first step, {difference[-1]:.1e} at the last (bound {bounds[-1]:.1e})"
        result.checks.append(Check(column, float((difference / bounds).max()), 1.0, detail))


def _compare_print(result: SceneResult, lammps: LammpsResult, octant: OctantResult, bound: float) -> None:
    """The rows of the two log files as text. A difference far below the bounds above can still turn a digit."""
    theirs, ours = lammps.runs[-1].rows, octant.runs[-1].rows
    different = sum(a != b for a, b in zip(theirs, ours, strict=False)) + abs(len(theirs) - len(ours))
    result.checks.append(Check("rows that differ in print", different, bound, f"{len(theirs)} rows"))


def _compare_lists(result: SceneResult, lammps: LammpsResult, octant: OctantResult) -> None:
    """List length, builds and dangerous builds at the end of the run: equal."""
    theirs, ours = lammps.runs[-1].statistics, octant.summary["neighbors"]
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
