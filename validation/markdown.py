"""Numbers and tables of pages."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence


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
