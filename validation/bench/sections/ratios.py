"""octant beside LAMMPS and OpenMM, on one core and on all, with the force error of each."""

from __future__ import annotations

from validation.bench.contestants import Contestant, Lammps, Octant, OpenMM
from validation.bench.liquid import Liquids
from validation.bench.markdown import absences, caption, ratio, spread
from validation.bench.plan import ASKED_SPEED, MODES, Plan, atoms
from validation.bench.rounds import in_turns
from validation.bench.rows import ABSENT, COST, COST_UNIT, Row, Rows
from validation.markdown import cores, number, table

NAME = "ratios"

#: Begins the name of a ratio; the peer's name follows.
_OVER = "speed over "


def contestants(plan: Plan) -> list[Contestant]:
    """Everyone, on one core and on all."""
    everyone: list[Contestant] = []
    for threads in plan.thread_counts:
        everyone += [Octant(mode, threads) for mode in MODES]
        everyone += [Lammps(flavor, threads) for flavor in (("opt",) if threads == 1 else ("omp", "mpi"))]
        everyone.append(OpenMM(threads))
    return everyone


def measure(plan: Plan, liquids: Liquids) -> Rows:
    """Costs, and how many times as fast octant is as the best way to run LAMMPS on as many cores."""
    data, steps, count = liquids.data(plan.main), plan.steps(plan.main), atoms(plan.main)
    everyone = contestants(plan)
    turns = in_turns({one: lambda one=one: one.time(data, steps) for one in everyone}, plan.rounds, "contestants")
    rows = Rows()
    for one in everyone:
        if costs := turns.costs(one):
            rows.rows.append(Row.of(NAME, one.name, count, one.threads, COST, COST_UNIT, costs))
        else:
            rows.rows.append(Row.words(NAME, one.name, one.threads, ABSENT, turns.absent[one]))
    for threads in plan.thread_counts:
        costs = rows.where(value=COST, threads=threads)
        there = [one for one in everyone if one.threads == threads and turns.costs(one)]
        peers = [[one for one in there if isinstance(one, kind)] for kind in (Lammps, OpenMM)]
        for peer in [min(kind, key=lambda one: costs.median(contestant=one.name)) for kind in peers if kind]:
            for one in there:
                if isinstance(one, Octant):
                    ratios = turns.ratios(peer, one)
                    rows.rows.append(Row.of(NAME, one.name, count, threads, _OVER + peer.name, "ratio", ratios))
    return rows


def verdicts(rows: Rows) -> list[str]:
    """One line for each speed of octant over LAMMPS, with what is asked for."""
    lines = []
    for row in rows.where(section=NAME):
        if row.value.startswith(_OVER + "LAMMPS"):
            peer = row.value.removeprefix(_OVER) + (", the faster of omp and mpi" if row.threads > 1 else "")
            mode = row.contestant.removeprefix("octant ")
            asked = ASKED_SPEED.get((mode, row.threads == 1))
            line = f"{mode}, {cores(row.threads)}: {ratio(row)} of {peer}"
            lines.append(line + (f"; asked for: {asked:g}x, {_judged(row.median >= asked)}" if asked else ""))
    return lines


def _judged(reached: bool) -> str:
    return "reached" if reached else "**not reached**"


def summary(rows: Rows) -> list[str]:
    """Speed and error of everyone in one table."""
    ours = rows.where(section=NAME)
    lines = []
    for row in ours.where(value=COST):
        same = ours.where(contestant=row.contestant, threads=row.threads)
        peer = {name.split()[2]: same.first(value=name) for name in same.distinct("value") if name.startswith(_OVER)}
        lines.append(
            [
                row.contestant,
                cores(row.threads),
                spread(row),
                number(1e3 / row.median),
                ratio(peer.get("LAMMPS")),
                ratio(peer.get("OpenMM")),
                number(row.error_rms, 2),
                number(row.error_max, 2),
            ]
        )
    heads = ["program", "cores", "ns per atom-step", "million atom-steps/s", "speed over LAMMPS", "speed over OpenMM"]
    return table([*heads, "force error, RMS", "force error, worst atom"], lines)


def render(rows: Rows) -> list[str]:
    """The head of the page: table and verdicts."""
    costs = rows.where(section=NAME, value=COST)
    if not costs:
        return []
    count = costs.rows[0].atoms
    about = (
        f"Lennard-Jones liquid of {count} atoms, density 0.8442, cutoff 2.5, skin 0.3, list built every 20 steps, each "
        "program's own loop time with list builds. Speed over LAMMPS: over `opt` on one core, over the faster of `omp` "
        "and `opt` on MPI processes on several; ratios are taken within each round. Force errors are relative to the "
        "RMS force."
    )
    said = [f"- {line}" for line in verdicts(rows)]
    absent = absences(rows.where(section=NAME))
    return ["## Speed", "", *caption(costs, about), *summary(rows), *absent, *said, ""]
