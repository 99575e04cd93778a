"""The summary of a run: a page and JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from validation.bundle.comparison import Row
from validation.bundle.outcome import FAILED, PASSED, SKIPPED, Outcome

#: Exit status of ``run.sh``. A run in which nothing failed but something was skipped has not shown what it was to show.
STATUS = {PASSED: 0, FAILED: 1, SKIPPED: 77}


def overall(outcomes: Sequence[Outcome]) -> str:
    """FAILED where anything failed, SKIPPED where any test or part was left out, or nothing was run."""
    if any(outcome.verdict == FAILED for outcome in outcomes):
        return FAILED
    whole = bool(outcomes) and all(outcome.verdict == PASSED and outcome.skipped == 0 for outcome in outcomes)
    return PASSED if whole else SKIPPED


def write(folder: Path, about: Mapping[str, Any], outcomes: Sequence[Outcome], table: Sequence[Row]) -> None:
    """Writes ``summary.md`` and ``summary.json``."""
    data = {
        **about,
        "verdict": overall(outcomes),
        "outcomes": [outcome.as_json() for outcome in outcomes],
        "validation": [row.as_json() for row in table],
    }
    (folder / "summary.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    (folder / "summary.md").write_text(page(about, outcomes, table), encoding="utf-8")


def page(about: Mapping[str, Any], outcomes: Sequence[Outcome], table: Sequence[Row]) -> str:
    """The summary as Markdown."""
    wrong = [f"{outcome.part}, {outcome.name}" for outcome in outcomes if outcome.verdict == FAILED]
    counts = {verdict: sum(outcome.verdict == verdict for outcome in outcomes) for verdict in (PASSED, FAILED, SKIPPED)}
    lines = [
        "# Tests of octant",
        "",
        *(f"- {name}: {value}" for name, value in about.items()),
        f"- verdict: **{overall(outcomes)}** ({', '.join(f'{count} {verdict}' for verdict, count in counts.items())})",
        *([f"- failed: {'; '.join(wrong)}"] if wrong else []),
        "",
    ]
    for part in dict.fromkeys(outcome.part for outcome in outcomes):
        lines += [
            f"## {part}",
            "",
            "| | verdict | passed | failed | skipped | seconds | |",
            "|---|---|---:|---:|---:|---:|---|",
        ]
        for outcome in (outcome for outcome in outcomes if outcome.part == part):
            verdict = outcome.verdict if outcome.verdict == PASSED else f"**{outcome.verdict}**"
            numbers = f"{outcome.passed} | {outcome.failed} | {outcome.skipped} | {outcome.seconds:.1f}"
            lines.append(f"| {outcome.name} | {verdict} | {numbers} | {_cell(outcome.detail)} |")
        lines.append("")
    if table:
        lines += [
            "## Beside LAMMPS",
            "",
            "| scene | precision | worst force error | thermo rows equal in print | neighbors | outside tolerance |",
            "|---|---|---:|---:|---|---|",
        ]
        for row in table:
            force = "-" if row.force_error is None else f"{row.force_error:.1e}"
            cells = [row.scene, row.precision, force, row.rows, row.neighbors, _cell(", ".join(row.outside)) or "none"]
            lines.append("| " + " | ".join(cells) + " |")
        lines.append("")
    return "\n".join(lines)


def _cell(text: str) -> str:
    """One line that does not end a cell."""
    return " ".join(text.split()).replace("|", "/")[:300]
