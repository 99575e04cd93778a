"""octant with narrower instruction sets than the processor has."""

from __future__ import annotations

from validation.bench.contestants import Octant
from validation.bench.liquid import Liquids
from validation.bench.markdown import absences, caption, ratio, spread
from validation.bench.plan import MODES, Plan, atoms
from validation.bench.rounds import in_turns
from validation.bench.rows import ABSENT, COST, COST_UNIT, Row, Rows
from validation.markdown import table

NAME = "isa"

#: Values of the environment variable OCTANT_ISA, the widest first.
SETS = ("avx512", "avx2", "portable")

_OVER = "speed over portable"


def measure(plan: Plan, liquids: Liquids) -> Rows:
    """Every mode with every instruction set, one core, at the main size."""
    data, steps, count = liquids.data(plan.main), plan.steps(plan.main), atoms(plan.main)
    everyone = [Octant(mode, 1, isa) for mode in MODES for isa in SETS]
    turns = in_turns({one: lambda one=one: one.time(data, steps) for one in everyone}, plan.rounds, "instruction sets")
    rows = Rows()
    for one in everyone:
        if one in turns.absent:
            rows.rows.append(Row.words(NAME, one.name, 1, ABSENT, turns.absent[one]))
            continue
        rows.rows.append(Row.of(NAME, one.name, count, 1, COST, COST_UNIT, turns.costs(one)))
        portable = Octant(one.mode, 1, SETS[-1])
        if ratios := turns.ratios(portable, one):
            rows.rows.append(Row.of(NAME, one.name, count, 1, _OVER, "ratio", ratios))
    return rows


def render(rows: Rows) -> list[str]:
    """One line for each mode and instruction set."""
    ours = rows.where(section=NAME)
    costs = ours.where(value=COST)
    if not costs:
        return ["## Instruction sets", "", *absences(ours)] if ours else []
    lines = [[row.contestant, spread(row), ratio(ours.first(contestant=row.contestant, value=_OVER))] for row in costs]
    about = f"Instruction sets asked for with OCTANT_ISA, one core, {costs.rows[0].atoms} atoms."
    page = ["## Instruction sets", "", *caption(costs, about)]
    return [*page, *table(["program", "ns per atom-step", "speed over portable"], lines), *absences(ours)]
