"""Checks as rows of the table of stability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from validation.check import Check
from validation.truth.fluid import BACKEND


@dataclass(frozen=True)
class Known(Check):
    """Something measured beside what is known; ``reason`` says where the bound comes from."""

    reason: str = ""

    def row(self, precision: str) -> dict[str, Any]:
        """As the suite of ``tests/stability`` writes its own."""
        return {
            "section": "external truth",
            "case": self.name,
            "backend": BACKEND,
            "precision": precision,
            "variant": f"{BACKEND} {precision}",
            "measured": self.detail,
            "value": self.value,
            "bound": self.bound,
            "holds": self.passed,
            "reason": self.reason,
        }
