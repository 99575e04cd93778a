"""Force errors against all-pairs sums in double precision, also far from the origin, and the drift of the energy."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from validation.bench.contestants import Contestant, Lammps, Octant, OpenMM
from validation.bench.liquid import CUTOFF, PAIR, Atoms, Liquids, script
from validation.bench.markdown import absences, caption
from validation.bench.plan import MODES, Plan, atoms
from validation.bench.reference import Reference, all_pairs
from validation.bench.rounds import Absent, say
from validation.bench.rows import ABSENT, Row, Rows
from validation.logs import read_log
from validation.markdown import number, table

NAME = "errors"

HERE, MOVED, DRIFT, SCATTER = "force error", "force error, moved box", "energy drift", "energy scatter"

#: Where the box is moved to, in sigma.
FAR = 1e6

#: A pair this near the cutoff may be on either side of it in single precision, which makes a force jump.
_EDGE = 1e-5

_SEED = 20240607


def measure(plan: Plan, liquids: Liquids) -> Rows:
    """Errors at every size, in the moved box at the main size, and the drift."""
    rows = Rows()
    everyone: list[Contestant] = [*(Octant(mode, 1) for mode in MODES), Lammps("opt", 1), OpenMM(1)]
    several: list[Contestant] = [Lammps(flavor, plan.threads) for flavor in ("omp", "mpi") if plan.threads > 1]
    for size in sorted({*plan.sizes, plan.main}):
        here = everyone + (several if size == plan.main else [])
        rows.rows += _forces(plan, size, liquids.data(size), liquids.atoms(size), here, HERE)
    far = liquids.atoms(plan.main).moved(FAR)
    rows.rows += _forces(plan, plan.main, liquids.changed(plan.main, "moved", far), far, everyone[:-1], MOVED)
    for one in everyone[:-1]:
        rows.rows += _attempt(one, lambda one=one: _drift(plan, liquids, one))
    seen = rows.where(value=ABSENT).distinct("contestant")
    kept = [row for row in rows if row.value != ABSENT]
    return Rows([*kept, *(rows.first(value=ABSENT, contestant=name) for name in seen)])


def _attempt(one: Contestant, work: Callable[[], list[Row]]) -> list[Row]:
    try:
        return work()
    except Absent as reason:
        return [Row.words(NAME, one.name, one.threads, ABSENT, str(reason))]


def _forces(plan: Plan, size: int, data: Path, liquid: Atoms, everyone: list[Contestant], value: str) -> list[Row]:
    """The errors of everyone's forces on one liquid."""
    say(f"forces on {atoms(size)} atoms by definition")
    sample = None
    if atoms(size) > plan.all_atoms:
        sample = np.sort(np.random.default_rng(_SEED).choice(atoms(size), plan.sampled_atoms, replace=False))
    exact = all_pairs(liquid.positions, liquid.bounds, sample)
    rows: list[Row] = []
    for one in everyone:
        rows += _attempt(one, lambda one=one: _rows(one, atoms(size), value, exact, one.forces(data)))
    return rows


def _rows(one: Contestant, count: int, value: str, exact: Reference, forces: NDArray[np.float64]) -> list[Row]:
    """The error over all atoms, and over those without a pair at the cutoff."""
    rows = []
    for what, inside in ((value, exact.edge >= 0), (f"{value}, no pair at the cutoff", exact.edge > _EDGE)):
        rms, worst = relative_errors(forces[exact.atoms][inside], exact.forces[inside])
        numbers = {"rounds": 1, "error_rms": rms, "error_max": worst}
        rows.append(Row(NAME, one.name, count, one.threads, what, "of the RMS force", **numbers))
    return rows


def relative_errors(forces: NDArray[np.float64], exact: NDArray[np.float64]) -> tuple[float, float]:
    """RMS and largest length of the error vectors, over the RMS length of the exact forces."""
    scale = np.sqrt(np.mean(np.sum(exact**2, axis=1)))
    lengths = np.sqrt(np.sum((forces - exact) ** 2, axis=1))
    return float(np.sqrt(np.mean(lengths**2)) / scale), float(lengths.max() / scale)


def _drift(plan: Plan, liquids: Liquids, one: Octant | Lammps) -> list[Row]:
    """Slope of the total energy of an atom, and the scatter about it, with the default list policy."""
    say(f"drift of {one.name}")
    count = atoms(plan.drift_size)
    scene = script(
        liquids.data(plan.drift_size),
        plan.drift_steps,
        pair=(*PAIR, "pair_modify shift yes"),
        neighbor=(),
        output=(f"thermo {max(1, plan.drift_steps // 200)}", "thermo_modify format float %.15g"),
    )
    if isinstance(one, Octant):
        thermo = one.run(scene)["thermo"]
        points = [(row["Step"], row["TotEng"]) for row in thermo]
    else:
        with tempfile.TemporaryDirectory(prefix="drift-") as folder:
            log = Path(folder) / "log"
            log.write_text(one.run(scene), encoding="utf-8")
            run = read_log(log)[-1]
        points = list(zip(run.column("Step"), run.column("TotEng"), strict=True))
    steps, energies = np.array(points).T
    slope, start = np.polyfit(steps, energies, 1)
    scatter = np.std(energies - slope * steps - start)
    where = (NAME, one.name, count, 1)
    return [
        Row.of(*where, DRIFT, "epsilon/atom/1000 steps", [1000 * slope]),
        Row.of(*where, SCATTER, "epsilon/atom", [scatter]),
    ]


def render(rows: Rows) -> list[str]:
    """A table of force errors, one of the drift."""
    ours = rows.where(section=NAME)
    forces = Rows(row for row in ours if row.value in (HERE, MOVED))
    if not forces:
        return []
    jump = 24 / CUTOFF**7 - 48 / CUTOFF**13
    lines = []
    for row in forces:
        apart = ours.first(
            contestant=row.contestant, atoms=row.atoms, value=f"{row.value}, no pair at the cutoff", threads=row.threads
        )
        place = "at the origin" if row.value == HERE else f"{FAR:.0e} sigma away".replace("e+0", "e")
        errors = [row.error_rms, row.error_max, apart.error_max if apart else float("nan")]
        lines.append([row.contestant, str(row.atoms), place, *(number(error, 2) for error in errors)])
    about = (
        "Force error on the melted liquid against all-pairs nearest-image sums in double precision, relative to the "
        "RMS force; of all atoms of the smaller liquids, of a random sample of the larger ones. A pair within rounding "
        f"of the cutoff may be counted or not, which changes a force by {jump:.2g} epsilon/sigma: the last column "
        f"leaves out atoms with a pair within {_EDGE:g} sigma of it. The moved box is compared with sums over the "
        "moved positions as doubles hold them."
    )
    page = ["## Force error", "", *caption(forces, about)]
    page += table(["program", "atoms", "box", "RMS", "worst atom", "worst, no pair at the cutoff"], lines)
    if drift := ours.where(value=DRIFT):
        about = (
            f"Total energy of {drift.rows[0].atoms} atoms in NVE, potential shifted to zero at the cutoff, time step "
            "0.005, default list policy: slope of a straight line through the thermo table, and the scatter about it. "
            "The force still jumps at the cutoff, so that the energy wanders in double precision too: that is the "
            "scale to compare with."
        )
        page += caption(drift, about)
        page += table(
            ["program", "drift, epsilon per atom and 1000 steps", "scatter, epsilon per atom"],
            (
                [
                    row.contestant,
                    number(row.median, 2),
                    number(ours.median(contestant=row.contestant, value=SCATTER), 2),
                ]
                for row in drift
            ),
        )
    return page + absences(ours)
