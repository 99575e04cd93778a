"""The faster precisions beside LAMMPS: forces of one configuration, first row and total energy of the whole run, lists."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from validation import tolerances
from validation.check import Check
from validation.logs import Run
from validation.octant_runner import OctantResult

#: Names of ``--precision``, the most exact first; octant's double precision is compared digit by digit.
ALL = ("double", "mixed", "single")

#: Energy columns: the pair energy and the total, as the thermo styles name them.
_PAIR, _TOTAL = ("E_pair", "PotEng"), "TotEng"


def compare(
    precision: str,
    ours: NDArray[np.float64],
    theirs: NDArray[np.float64],
    whole: OctantResult,
    run: Run,
) -> list[Check]:
    """Forces on the melted atoms; pair energy and pressure at the first step, and the total energy, of the whole run:
    ``whole`` octant's, ``run`` LAMMPS's."""
    size = np.sqrt((theirs**2).sum(axis=1))
    rms = np.sqrt((size**2).mean())
    off = np.sqrt(((ours - theirs) ** 2).sum(axis=1))
    checks = [
        Check(f"{precision}: forces, RMS", float(np.sqrt((off**2).mean()) / rms), tolerances.FAST_FORCE_RMS[precision].value),
        Check(f"{precision}: forces, max", float((off / np.maximum(size, rms)).max()), tolerances.FAST_FORCE_MAX.value),
    ]
    rows = whole.summary["thermo"]
    pair = next((name for name in _PAIR if name in run.columns), None)
    if pair and "Press" in run.columns:
        reference = run.column(pair)[0]
        scale = abs(reference) or 1.0
        checks.append(
            Check(f"{precision}: energy", abs(rows[0][pair] - reference) / scale, tolerances.FAST_SUM.value)
        )
        pressures = np.array(run.column("Press"))
        difference = abs(rows[0]["Press"] - pressures[0]) / np.abs(pressures).max()
        checks.append(Check(f"{precision}: pressure", float(difference), tolerances.FAST_SUM.value))
    if _TOTAL in run.columns:
        energies = {"LAMMPS": np.array(run.column(_TOTAL)), "octant": np.array([row[_TOTAL] for row in rows])}
        wander = {name: float(np.abs(column - column[0]).max()) for name, column in energies.items()}
        # What f32 adds to a run that conserves energy almost exactly.
        rounding = 1e-5 * float(np.abs(energies["LAMMPS"]).max())
        checks.append(
            Check(
                f"{precision}: total energy",
                wander["octant"] / (wander["LAMMPS"] + rounding),
                tolerances.WANDER.value,
                f"wanders by {wander['octant']:.2e}, LAMMPS by {wander['LAMMPS']:.2e}",
            )
        )
    return checks


def compare_lists(precision: str, ours: OctantResult, neighbors: NDArray[np.int64]) -> Check:
    """List length on the melted atoms: LAMMPS's, from its neighbors of every atom. Single precision rounds positions, so a
    pair within 1e-7 of the cutoff may change sides."""
    length, reference = ours.summary["neighbors"]["total"], int(neighbors.sum()) // 2
    allowed = max(2, round(1e-5 * reference)) if precision == "single" else 0
    return Check(f"{precision}: list length", abs(length - reference), allowed, f"{length}")
