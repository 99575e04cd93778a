"""How far apart the two programs may be, and why."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerance:
    """A bound and where it comes from."""

    value: float
    reason: str

    def __str__(self) -> str:
        return f"{self.value:.1g} for {self.reason}"


#: Growth rate of a small difference between two trajectories of the Lennard-Jones liquid, 1 / Lennard-Jones time.
LYAPUNOV = 3.6

#: Length of the run after which positions are compared, steps.
SHORT_RUN = 10

#: Thermo columns, relative to the column's largest magnitude, where a run begins.
THERMO = Tolerance(
    1e-13,
    "the difference of two trajectories that differ by rounding, which grows as "
    f"exp({LYAPUNOV} t), t in Lennard-Jones times",
)

#: LAMMPS adds one pair after the other to a single number. Each addition rounds by up to this much, and on a perfect
#: lattice, where all terms are alike, every rounding has the same sign.
ADDITION = Tolerance(2.0**-53, "rounding of one addition, times the number of pairs that LAMMPS adds up")

FORCE_MAX = Tolerance(
    1e-12,
    "the largest difference of a force component over the RMS force: rounding of a sum of large terms that nearly "
    "cancel",
)
FORCE_RMS = Tolerance(1e-13, "the RMS difference of the force components over the RMS force: the same, on average")
POSITION = Tolerance(
    1e-13,
    f"the largest difference after {SHORT_RUN} steps over the largest box length: rounding of {SHORT_RUN} additions",
)

#: Pair arithmetic of the faster precisions is that of f32.
FAST_FORCE_RMS = {
    "mixed": Tolerance(3e-6, "the RMS difference of the forces over the RMS force in mixed precision: rounding of f32"),
    "single": Tolerance(
        1e-5, "that in single precision: positions are rounded to 2e-7 of a cell, and in a crystal large terms cancel"
    ),
}
FAST_FORCE_MAX = Tolerance(3e-5, "the worst atom, over the RMS force or its own, whichever is larger")
FAST_SUM = Tolerance(1e-5, "the difference over the largest value in the run; terms of both signs cancel")
#: The total energy of a chaotic run differs between any two programs; how far it wanders does not.
WANDER = Tolerance(3.0, "how far the total energy wanders in a run, over how far it does in LAMMPS")


def thermo_bound(time: float, pairs: float) -> float:
    """Bound on the relative difference of a thermo column after ``time`` Lennard-Jones times, ``pairs`` in the list."""
    return THERMO.value * math.exp(LYAPUNOV * time) + ADDITION.value * pairs
