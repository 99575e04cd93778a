"""How far apart the two programs may be, and why."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerance:
    """A bound and where it comes from."""

    value: float
    reason: str


#: Growth rate of a small difference between two trajectories of the Lennard-Jones liquid, 1 / Lennard-Jones time.
LYAPUNOV = 3.6

#: Length of the run after which positions are compared, steps.
SHORT_RUN = 10

#: Thermo columns at the first step of a run, relative to the column's largest magnitude.
THERMO = Tolerance(
    1e-11,
    "sums of the same pair terms in another order; afterwards the difference of two trajectories that differ by rounding "
    f"grows as exp({LYAPUNOV} t), t in Lennard-Jones times",
)

FORCE_MAX = Tolerance(1e-12, "largest difference of a force component over the RMS force: rounding of a sum of large terms that nearly cancel")
FORCE_RMS = Tolerance(1e-13, "RMS difference of the force components over the RMS force: the same, on average")
POSITION = Tolerance(1e-13, f"largest difference after {SHORT_RUN} steps over the largest box length: rounding of {SHORT_RUN} additions")


def thermo_bound(time: float) -> float:
    """Bound on the relative difference of a thermo column after ``time`` Lennard-Jones times."""
    return THERMO.value * math.exp(LYAPUNOV * time)
