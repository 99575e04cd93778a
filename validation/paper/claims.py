"""The paper's three claims, judged by what was measured: numbers and turns of the text come from the rows."""

from __future__ import annotations

from validation.paper.claim import Claim
from validation.paper.dispersion import order
from validation.paper.edges import edge, gain
from validation.paper.results import Results


def judge(results: Results) -> list[Claim]:
    """The three claims in the paper's order."""
    return [order(results), gain(results), edge(results)]
