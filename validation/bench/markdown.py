"""Numbers, tables and captions of the page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from validation.bench.rows import ABSENT, Row, Rows


def number(value: float, digits: int = 3) -> str:
    """A number with some significant digits, never in powers of ten unless it is tiny; a dash where there is none."""
    if math.isnan(value):
        return "-"
    if value != 0 and abs(value) < 1e-3:
        return f"{value:.1e}"
    decimals = digits - 1 - math.floor(math.log10(abs(value))) if value else 0
    return f"{round(value, decimals):,.{max(decimals, 0)}f}".replace(",", " ")


def spaced(count: int) -> str:
    """A number of atoms with blanks between the thousands."""
    return f"{count:,}".replace(",", " ")


def spread(row: Row | None) -> str:
    """Median and quartiles: ``120 (118 to 123)``."""
    return "-" if row is None else f"{number(row.median)} ({number(row.q1)} to {number(row.q3)})"


def ratio(row: Row | None) -> str:
    """Median and quartiles of a ratio: ``5.12x (4.93 to 5.31)``."""
    return "-" if row is None else f"{row.median:.2f}x ({row.q1:.2f} to {row.q3:.2f})"


def cores(threads: int) -> str:
    """``one core``, ``2 cores``."""
    return "one core" if threads == 1 else f"{threads} cores"


def table(heads: Sequence[str], lines: Iterable[Sequence[str]]) -> list[str]:
    """A table whose first column holds words and the others numbers."""
    aligned = [
        "| " + " | ".join(heads) + " |",
        "|---|" + "---:|" * (len(heads) - 1),
        *("| " + " | ".join(line) + " |" for line in lines),
    ]
    return [*aligned, ""]


def caption(rows: Rows, text: str) -> list[str]:
    """What a table shows, with machine, date and commit, so that it can be read by itself."""
    row = next(iter(rows))
    rounds = max(row.rounds for row in rows)
    # The instruction sets stand at the head of the page.
    place = ", ".join(row.machine.split(", ")[:2])
    turns = f"Median (quartiles) of {rounds} rounds in turns. " if rounds > 1 else ""
    return [f"{text} {turns}{place}, {row.date}, commit {row.commit}.", ""]


def absences(rows: Rows) -> list[str]:
    """A line for each contestant that could not be measured."""
    lines = [f"- {row.contestant}, {cores(row.threads)}: absent, {row.unit}" for row in rows.where(value=ABSENT)]
    return [*lines, ""] if lines else []
