"""The scenes that are compared.

Every script of ``inputs/``, and those of ``validation/scenes/``, which only a comparison needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from validation.octant_runner import ROOT

INPUTS = ROOT / "inputs"
EXTRA = ROOT / "validation" / "scenes"


@dataclass(frozen=True)
class Scene:
    """A script and what the comparison has to know about it."""

    path: Path
    #: Lennard-Jones time sigma sqrt(m / epsilon) of its atoms, in its own time units.
    lj_time: float = 1.0
    #: Variables set for every comparison.
    variables: Mapping[str, str | int] = field(default_factory=dict)
    #: Variables that make it a matter of a second.
    quick: Mapping[str, str | int] = field(default_factory=dict)
    #: Every printed digit of the thermo table must be LAMMPS's.
    every_digit: bool = False

    @property
    def name(self) -> str:
        return self.path.stem


# What differs from the defaults. A script that is not named here is compared all the same.
_KNOWN: dict[str, dict] = {
    "benchmark": {"quick": {"size": 8}, "every_digit": True},
    "cluster": {"quick": {"steps": 200}},
    "dense": {"quick": {"size": 5, "steps": 60}},
    "dilute": {"quick": {"size": 6, "steps": 300}},
    "images": {"quick": {"steps": 100}},
    "melt": {"quick": {"size": 6, "steps": 150}},
    "metal": {"lj_time": 0.418, "quick": {"size": 6, "steps": 100}},
    "morse": {"lj_time": 0.418, "quick": {"size": 4, "steps": 100}},
    "mixture": {"variables": {"data": str(INPUTS / "mixture.data")}, "quick": {"steps": 100}},
    "real": {"lj_time": 2151.0, "quick": {"size": 5, "steps": 200}},
    "drag": {"lj_time": 2.15, "quick": {"steps": 150}},
    "limit": {"quick": {"steps": 100}},
    "nvt": {"quick": {"steps": 100}},
    # Cores three times as stiff as those of Lennard-Jones particles.
    "mie": {"lj_time": 0.6, "quick": {"size": 5, "steps": 120}},
    "tail": {"quick": {"steps": 150}},
    "walls": {"quick": {"steps": 150}},
    "yukawa": {"quick": {"size": 5, "steps": 150}},
    "smooth": {"quick": {"size": 5, "steps": 120}},
    # As much faster as its potential is steeper and its atoms lighter.
    "stiff": {"lj_time": 0.1, "quick": {"size": 5, "steps": 200}},
    "slab": {"quick": {"size": 5, "steps": 160}},
}


def all_scenes() -> list[Scene]:
    """Every script of the two folders, each in the order of their names."""
    paths = [*sorted(INPUTS.glob("*.in")), *sorted(EXTRA.glob("*.in"))]
    return [Scene(path, **_KNOWN.get(path.stem, {})) for path in paths]
