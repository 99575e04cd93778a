"""What a judged claim is made of, and how near to each other two things have to be to be called alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from validation.markdown import number
from validation.paper.results import Time

HOLDS, PART, FAILS = "holds", "holds in part", "fails"

#: A line is called straight where nothing measured is further from it than this part of itself, and two things alike
#: where they differ by no more.
ALIKE = 0.10


@dataclass(frozen=True)
class Claim:
    """A claim, what became of it in a few words, and why."""

    verdict: str
    short: str
    lines: list[str]


def timed(time: Time) -> str:
    """Median, and in brackets least and most."""
    return f"{number(time.median)} ({number(time.least)} to {number(time.most)})"


def span(values: Sequence[float]) -> str:
    """Least and greatest of ratios."""
    return f"{min(values):.2f} to {max(values):.2f}"
