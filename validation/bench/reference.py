"""Forces by definition: every atom against all others, nearest image, in double precision."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from validation.bench.liquid import CUTOFF

#: Atoms that one is compared with at a time: the working arrays stay in the cache of a core.
_BLOCK = 1 << 15

#: Distances beyond the cutoff that are looked at.
EDGE = 1e-2


@dataclass(frozen=True)
class Reference:
    """Exact forces on some atoms."""

    #: Their places in the order of the ids.
    atoms: NDArray[np.int64]
    #: Shape (atoms, 3).
    forces: NDArray[np.float64]
    #: How near an atom comes to having a pair at the cutoff: the smallest difference of a distance from it, as far as
    #: that is below ``EDGE``.
    edge: NDArray[np.float64]


def all_pairs(
    positions: NDArray[np.float64],
    bounds: NDArray[np.float64],
    atoms: Sequence[int] | NDArray[np.int64] | None = None,
    cutoff: float = CUTOFF,
) -> Reference:
    """Lennard-Jones forces on ``atoms`` (all by default) in a periodic box that is at least two cutoffs wide."""
    chosen = np.arange(len(positions)) if atoms is None else np.asarray(atoms, dtype=np.int64)
    lengths = bounds[:, 1] - bounds[:, 0]
    if lengths.min() < 2 * cutoff:
        raise ValueError("the nearest image is not enough in a box narrower than two cutoffs")
    columns = np.ascontiguousarray(positions.T)
    forces, edge = np.zeros((len(chosen), 3)), np.full(len(chosen), np.inf)
    work = np.empty((5, min(_BLOCK, len(positions))))
    for place, atom in enumerate(chosen):
        terms = []
        for start in range(0, len(positions), _BLOCK):
            block = columns[:, start : start + _BLOCK]
            separation, squared = _separations(positions[atom], block, lengths, work[:, : block.shape[1]])
            if start <= atom < start + block.shape[1]:
                squared[atom - start] = np.inf
            near = np.flatnonzero(squared < (cutoff + EDGE) ** 2)
            edge[place] = np.abs(np.sqrt(squared[near]) - cutoff).min(initial=edge[place])
            near = near[squared[near] < cutoff**2]
            inverse = 1 / squared[near]
            sixth = inverse**3
            terms.append(24 * sixth * (2 * sixth - 1) * inverse * separation[:, near])
        # Summed without rounding, so that the order in which terms come does not matter.
        forces[place] = [math.fsum(axis) for axis in np.concatenate(terms, axis=1)]
    return Reference(chosen, forces, edge)


def _separations(
    position: NDArray[np.float64], block: NDArray[np.float64], lengths: NDArray[np.float64], work: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nearest-image vectors from the atoms of a block to one position, and their squared lengths."""
    separation, squared, scratch = work[:3], work[3], work[4]
    squared[:] = 0
    for axis in range(3):
        delta = separation[axis]
        np.subtract(position[axis], block[axis], out=delta)
        np.multiply(delta, 1 / lengths[axis], out=scratch)
        np.rint(scratch, out=scratch)
        np.multiply(scratch, lengths[axis], out=scratch)
        np.subtract(delta, scratch, out=delta)
        np.multiply(delta, delta, out=scratch)
        np.add(squared, scratch, out=squared)
    return separation, squared
