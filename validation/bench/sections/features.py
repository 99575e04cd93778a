"""What each feature costs octant, next to the plain liquid."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from validation.bench.contestants import Octant
from validation.bench.liquid import LIST, PAIR, Liquids, script
from validation.bench.markdown import absences, caption, ratio, spread
from validation.bench.plan import Plan, atoms
from validation.bench.rounds import in_turns
from validation.bench.rows import ABSENT, COST, COST_UNIT, Row, Rows
from validation.markdown import number, table
from validation.scripts import Script

NAME = "features"

BASE = "plain liquid"

_OVER, _PAIRS, _BUILDS = "cost over plain", "pairs", "builds"

#: Empty space around the liquid without periodic sides, sigma: more than an atom flies in a timed run.
_MARGIN = 40.0


@dataclass(frozen=True)
class Feature:
    """A changed scene."""

    name: str
    scene: Script


def features(plan: Plan, liquids: Liquids, steps: int) -> list[Feature]:
    """The scenes, the plain one first."""
    size, count = plan.main, atoms(plan.main)
    data, liquid = liquids.data(size), liquids.atoms(size)
    two = liquids.changed(size, "two", liquid.two_types())
    wide = liquids.changed(size, "wide", liquid.in_wider_box(_MARGIN))

    def plain(path: Path = data, **changed: tuple[str, ...]) -> Script:
        return script(path, steps, **changed)

    style = "pair_style lj/cut 2.5"
    cutoffs = (style, "pair_coeff 1 1 1 1 2.5", "pair_coeff 1 2 1 1 2.4", "pair_coeff 2 2 1 1 2.3")
    group = (f"group most id 1:{count - 1}", "fix motion most nve")
    checked = "neigh_modify delay 0 every {} check yes"
    return [
        Feature(BASE, plain()),
        Feature("two types, equal coefficients", plain(two)),
        Feature("two types, cutoffs 2.5, 2.4, 2.3", plain(two, pair=cutoffs)),
        Feature("pair_modify shift yes", plain(pair=(*PAIR, "pair_modify shift yes"))),
        Feature("thermo 1", plain(output=("thermo 1",))),
        Feature("every 20, check yes", plain(neighbor=(LIST[0], checked.format(20)))),
        Feature("every 1, check yes", plain(neighbor=(LIST[0], checked.format(1)))),
        Feature("fix on a group of all atoms but one", plain(motion=group)),
        Feature("boundary f f f", plain(wide, head=("boundary f f f",))),
        Feature("morse", plain(pair=("pair_style morse 2.5", "pair_coeff * * 1.0 5.35 1.1225"))),
        Feature("yukawa", plain(pair=("pair_style yukawa 2.0 2.5", "pair_coeff * * 10.0"))),
    ]


def measure(plan: Plan, liquids: Liquids) -> Rows:
    """Every feature on one core in mixed precision; a binary without it is measured in double."""
    steps, count = max(plan.least_steps, plan.steps(plan.main) // 40 * 20), atoms(plan.main)
    scenes = features(plan, liquids, steps)
    data = liquids.data(plan.main)
    rows = Rows()
    for one in (Octant("mixed", 1), Octant("double", 1)):
        jobs = {scene.name: lambda scene=scene, one=one: one.time(data, steps, scene.scene) for scene in scenes}
        probe = in_turns({BASE: jobs[BASE]}, 1, f"features, {one.mode}")
        if not probe.absent:
            break
        rows.rows.append(Row.words(NAME, one.name, 1, ABSENT, probe.absent[BASE]))
    else:
        return rows
    turns = in_turns(jobs, plan.rounds, "features")
    for scene in scenes:
        name = f"{one.name}: {scene.name}"
        if scene.name in turns.absent:
            rows.rows.append(Row.words(NAME, name, 1, ABSENT, turns.absent[scene.name]))
            continue
        where = (NAME, name, count, 1)
        rows.rows.append(Row.of(*where, COST, COST_UNIT, turns.costs(scene.name)))
        rows.rows.append(Row.of(*where, _OVER, "ratio", turns.ratios(scene.name, BASE)))
        neighbors = [sample.report["neighbors"] for sample in turns.samples[scene.name]]
        rows.rows.append(Row.of(*where, _PAIRS, "1/atom", [each["per_atom"] for each in neighbors]))
        rows.rows.append(Row.of(*where, _BUILDS, "1/run", [each["builds"] for each in neighbors]))
    return rows


def render(rows: Rows) -> list[str]:
    """One line for each feature."""
    ours = rows.where(section=NAME)
    costs = ours.where(value=COST)
    if not costs:
        return []
    program = costs.rows[0].contestant.split(":")[0]
    lines = []
    for cost in costs:
        same = ours.where(contestant=cost.contestant)
        told = [number(same.median(value=_PAIRS)), number(same.median(value=_BUILDS), 2)]
        lines.append([cost.contestant.split(": ")[1], spread(cost), ratio(same.first(value=_OVER)), *told])
    about = (
        f"{program}, one core, {costs.rows[0].atoms} atoms: the plain liquid of the first table, and the same with one "
        "thing changed. Ratios are taken within each round. Pairs are those of the list at the end; fewer pairs or "
        "more builds are part of a ratio."
    )
    heads = ["scene", "ns per atom-step", "over plain", "pairs per atom", "list builds"]
    return ["## Features", "", *caption(costs, about), *table(heads, lines), *absences(ours)]
