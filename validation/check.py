"""One compared quantity."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Check:
    """One compared quantity: ``value`` is how far the two programs are apart, ``bound`` how far they may be."""

    name: str
    value: float
    bound: float
    #: What was compared, in words and numbers.
    detail: str = ""

    @property
    def passed(self) -> bool:
        return bool(self.value <= self.bound)  # false for NaN

    def as_json(self) -> dict[str, Any]:
        return {**asdict(self), "passed": self.passed}
