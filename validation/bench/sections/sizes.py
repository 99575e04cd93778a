"""Cost of an atom-step by the number of atoms: it should not depend on it."""

from __future__ import annotations

from validation.bench.contestants import Octant
from validation.bench.liquid import Liquids
from validation.bench.markdown import absences, caption, spread
from validation.bench.plan import ASKED_LINEAR, Plan, atoms
from validation.bench.rounds import in_turns
from validation.bench.rows import ABSENT, COST, COST_UNIT, Row, Rows
from validation.markdown import cores, table

NAME = "sizes"

#: Cost over that at the main size, round by round.
_RELATIVE = "cost over that of "


def measure(plan: Plan, liquids: Liquids) -> Rows:
    """octant in double and mixed precision at each size, on one core and on all."""
    everyone = [Octant(mode, threads) for mode in ("double", "mixed") for threads in plan.thread_counts]
    main = plan.main if plan.main in plan.sizes else plan.sizes[0]
    jobs = {}
    for size in plan.sizes:
        data, steps = liquids.data(size), plan.steps(size)
        for one in everyone:
            jobs[one, size] = lambda one=one, data=data, steps=steps: one.time(data, steps)
    turns = in_turns(jobs, plan.rounds, "sizes")
    rows = Rows()
    for one in everyone:
        for size in plan.sizes:
            if not (costs := turns.costs((one, size))):
                rows.rows.append(Row.words(NAME, one.name, one.threads, ABSENT, turns.absent[one, size]))
                break
            where = (NAME, one.name, atoms(size), one.threads)
            rows.rows.append(Row.of(*where, COST, COST_UNIT, costs))
            if ratios := turns.ratios((one, size), (one, main)):
                rows.rows.append(Row.of(*where, f"{_RELATIVE}{atoms(main)}", "ratio", ratios))
    return rows


def compared_size(rows: Rows) -> int:
    """The number of atoms that the other sizes are compared with; 0 where there is none."""
    names = (row.value for row in rows.where(section=NAME) if row.value.startswith(_RELATIVE))
    return next((int(name.removeprefix(_RELATIVE)) for name in names), 0)


def verdicts(rows: Rows) -> list[str]:
    """Largest deviation from the cost at the main size, for each contestant."""
    lines = []
    ours = Rows(row for row in rows.where(section=NAME) if row.value.startswith(_RELATIVE))
    for name in ours.distinct("contestant"):
        for threads in ours.distinct("threads"):
            if not (same := ours.where(contestant=name, threads=threads)):
                continue
            worst = max(same, key=lambda row: abs(row.median - 1))
            reached = "reached" if abs(worst.median - 1) <= ASKED_LINEAR else "**not reached**"
            median, low, high = (100 * (value - 1) for value in (worst.median, worst.q1, worst.q3))
            lines.append(
                f"{name.removeprefix('octant ')}, {cores(threads)}: farthest from the cost at "
                f"{worst.value.removeprefix(_RELATIVE)} atoms is that at {worst.atoms}, by {median:+.0f} % "
                f"({low:+.0f} to {high:+.0f}); asked for: within {100 * ASKED_LINEAR:.0f} %, {reached}"
            )
    return lines


def render(rows: Rows) -> list[str]:
    """A column for each contestant, a line for each size."""
    costs = rows.where(section=NAME, value=COST)
    if not costs:
        return []
    columns = [(n, t) for n in costs.distinct("contestant") for t in costs.where(contestant=n).distinct("threads")]
    lines = [
        [str(count), *(spread(costs.first(contestant=name, threads=threads, atoms=count)) for name, threads in columns)]
        for count in costs.distinct("atoms")
    ]
    heads = ["atoms", *(f"{name}, {cores(threads)}" for name, threads in columns)]
    about = "Cost by size, ns per atom-step, on the liquid of the first table."
    said = [f"- {line}" for line in verdicts(rows)]
    return [
        "## Size",
        "",
        *caption(costs, about),
        *table(heads, lines),
        *absences(rows.where(section=NAME)),
        *said,
        "",
    ]
