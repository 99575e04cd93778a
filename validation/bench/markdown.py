"""Medians, ratios and captions of the page."""

from __future__ import annotations

from validation.bench.rows import ABSENT, Row, Rows
from validation.markdown import cores, number


def spread(row: Row | None) -> str:
    """Median and quartiles: ``120 (118 to 123)``."""
    return "-" if row is None else f"{number(row.median)} ({number(row.q1)} to {number(row.q3)})"


def ratio(row: Row | None) -> str:
    """Median and quartiles of a ratio: ``5.12x (4.93 to 5.31)``."""
    return "-" if row is None else f"{row.median:.2f}x ({row.q1:.2f} to {row.q3:.2f})"


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
