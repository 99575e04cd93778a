"""Where octant's time goes, and how many cycles a pair takes."""

from __future__ import annotations

from typing import Any

from validation.bench import machine
from validation.bench.contestants import Octant
from validation.bench.liquid import LIST, Liquids, script
from validation.bench.markdown import absences, caption
from validation.bench.plan import MODES, Plan, atoms
from validation.bench.rounds import Sample, in_turns
from validation.bench.rows import ABSENT, CLOCK, COST, COST_UNIT, ISA, Row, Rows
from validation.markdown import cores, number, table

NAME = "stages"

#: Stages in the order of a step; ``sort``, ``list`` and ``check`` are parts of ``neighbor``.
STAGES = ("sort", "list", "check", "pair", "modify", "output", "other")

_SHARE = "share of "
_FLOOR = "floor"

#: A pair loop that takes less than this many times its floor is called bound by it.
_NEAR = 1.5

#: Derived quantities: name, unit, and how the page calls them.
_DERIVED = (
    ("pairs", "1/atom", "pairs per atom"),
    ("list entries", "1/atom", "list entries per atom"),
    ("distance tests", "1/atom/build", "distance tests per atom and build"),
    ("pair rate", "1e6/s", "million pairs/s"),
    ("cycles a pair", "cycles", "cycles per pair"),
    ("cycles an entry", "cycles", "cycles per list entry"),
    ("cycles a test", "cycles", "list cycles per distance test"),
    ("memory", "bytes/atom", "bytes per atom"),
)


def shares(report: dict[str, Any]) -> dict[str, float]:
    """Fraction of the loop time in each stage; a stage that the binary does not tell is left out."""
    timing = report["timing"]
    stages, loop = dict(timing["stages"]), timing["loop_s"]
    neighbor = stages.pop("neighbor", 0.0)
    if "sort" in stages and "list" in stages:
        # What is neither sorting nor listing decides whether to build, or wraps.
        stages.setdefault("check", max(neighbor - stages["sort"] - stages["list"], 0.0))
    else:
        stages = {"list": neighbor, **{name: seconds for name, seconds in stages.items() if name not in STAGES[:3]}}
    return {name: stages[name] / loop for name in STAGES if name in stages} if loop > 0 else {}


def derived(report: dict[str, Any], steps: int, threads: int, clock: float) -> dict[str, float]:
    """What follows from the report and the clock; a quantity that the binary does not tell is left out."""
    neighbors, stages, count = report["neighbors"], report["timing"]["stages"], report["atoms"]
    found: dict[str, float | None] = {
        "pairs": neighbors.get("per_atom"),
        "list entries": neighbors.get("list_entries_per_atom"),
        "distance tests": neighbors.get("distance_tests_per_atom"),
        "memory": _memory(report).get("bytes_per_atom"),
    }
    cycles = clock * threads * stages["pair"] / (steps * count)
    if pairs := found["pairs"]:
        found["pair rate"] = pairs * count * steps / stages["pair"] / 1e6 if stages["pair"] > 0 else None
        found["cycles a pair"] = cycles / pairs if clock else None
    if entries := found["list entries"]:
        found["cycles an entry"] = cycles / entries if clock else None
    if (tests := found["distance tests"]) and neighbors["builds"] and "list" in stages:
        found["cycles a test"] = (
            clock * threads * stages["list"] / (neighbors["builds"] * count * tests) if clock else None
        )
    return {name: value for name, value in found.items() if value is not None}


def _memory(report: dict[str, Any]) -> dict[str, Any]:
    return report.get("memory") or report["neighbors"].get("memory") or {}


def measure(plan: Plan, liquids: Liquids) -> Rows:
    """Every mode on one core and on all, at the main size."""
    data, steps, count = liquids.data(plan.main), plan.steps(plan.main), atoms(plan.main)
    plain = script(data, steps)
    everyone = [(Octant(mode, threads), "", plain) for threads in plan.thread_counts for mode in MODES]
    # The plain liquid never checks whether atoms have moved far enough.
    checked = script(data, steps, neighbor=(LIST[0], "neigh_modify delay 0 every 1 check yes"))
    everyone.append((Octant("mixed", 1), ", every 1, check yes", checked))
    clock, source = machine.clock()
    rows = Rows([Row.of(NAME, "machine", 0, 1, "clock", "GHz", [clock / 1e9])])
    rows.rows.append(Row.words(NAME, "machine", 1, CLOCK, source))
    jobs = {one.name + what + str(one.threads): (one, what, scene) for one, what, scene in everyone}
    runs = {key: lambda one=one, scene=scene: one.time(data, steps, scene) for key, (one, _, scene) in jobs.items()}
    turns = in_turns(runs, plan.rounds, "stages")
    for key, (one, what, _) in jobs.items():
        name = one.name + what
        if key in turns.absent:
            rows.rows.append(Row.words(NAME, name, one.threads, ABSENT, turns.absent[key]))
            continue
        where = (NAME, name, count, one.threads)
        rows.rows.append(Row.of(*where, COST, COST_UNIT, turns.costs(key)))
        samples = turns.samples[key]
        rows.rows += _told(where, samples, steps, clock)
        if (floor := plan.floor(one.mode)) is not None:
            rows.rows.append(Row.of(*where, _FLOOR, "cycles/entry", [floor]))
        if isa := samples[0].report["settings"].get("isa"):
            rows.rows.append(Row.words(NAME, name, one.threads, ISA, isa))
    return rows


def _told(where: tuple[str, str, int, int], samples: list[Sample], steps: int, clock: float) -> list[Row]:
    """Rows of shares and derived quantities."""
    parts = [shares(sample.report) for sample in samples]
    rows = [Row.of(*where, _SHARE + name, "%", [100 * part[name] for part in parts]) for name in parts[0]]
    numbers = [derived(sample.report, steps, where[3], clock) for sample in samples]
    for name, unit, _ in _DERIVED:
        if name in numbers[0]:
            rows.append(Row.of(*where, name, unit, [each[name] for each in numbers]))
    return rows


def bounds(rows: Rows) -> list[str]:
    """A sentence for each contestant on what bounds it, from the measured rows."""
    ours, lines, caches = rows.where(section=NAME), [], machine.caches()
    for cost in ours.where(value=COST):
        same = ours.where(contestant=cost.contestant, threads=cost.threads)
        parts = {row.value.removeprefix(_SHARE): row.median for row in same if row.value.startswith(_SHARE)}
        first = max(parts, key=lambda name: parts[name])
        line = f"{cost.contestant}, {cores(cost.threads)}: {first} takes {parts[first]:.0f} % of the loop"
        entry, floor, pair, memory = (
            same.first(value=value) for value in ("cycles an entry", _FLOOR, "cycles a pair", "memory")
        )
        if entry:
            line += f"; the pair loop takes {number(entry.median)} cycles a list entry"
            if floor:
                over = entry.median / floor.median
                near = "the arithmetic is the bound" if over < _NEAR else "something beside arithmetic is the bound"
                line += f", {over:.1f} times the given floor of {number(floor.median)}: {near}"
        elif pair:
            line += f"; the pair loop takes {number(pair.median)} cycles a pair"
        if memory:
            line += f"; it works on {memory.median * cost.atoms / 2**20:.1f} MiB (caches of all cores: {caches})"
        lines.append(line + ".")
    return lines


def render(rows: Rows) -> list[str]:
    """Shares, derived quantities, and the sentences."""
    ours = rows.where(section=NAME)
    costs = ours.where(value=COST)
    if not costs:
        return []
    names = [name for name in STAGES if ours.first(value=_SHARE + name)]
    clock = f"{number(ours.median(value='clock'))} GHz, from {ours.words(value=CLOCK)}"

    def cells(cost: Row, values: list[str]) -> list[str]:
        same = ours.where(contestant=cost.contestant, threads=cost.threads)
        return [cost.contestant, cores(cost.threads), *(number(same.median(value=value)) for value in values)]

    known = [(name, head) for name, _, head in _DERIVED if ours.first(value=name)]
    heads = ["program", "cores", "ns per atom-step", *(f"{name}, %" for name in names)]
    about = f"Share of the loop in each stage, {costs.rows[0].atoms} atoms, the liquid of the first table."
    page = ["## Stages", "", *caption(costs, about)]
    page += table(heads, (cells(cost, [COST, *(_SHARE + name for name in names)]) for cost in costs))
    sets = ours.where(value=ISA).distinct("unit")
    isa = f"Instruction set: {', '.join(sets)}." if sets else ""
    about = (
        "What the list holds and what the pair loop makes of it. A pair is two atoms within cutoff plus skin, counted "
        "once; a list entry is what the engine keeps, padding included; cycles are those of all cores together, at "
        f"{clock}. {isa}"
    )
    page += caption(costs, about.strip())
    page += table(
        ["program", "cores", *(head for _, head in known)], (cells(cost, [name for name, _ in known]) for cost in costs)
    )
    return [*page, *absences(ours), *(f"- {line}" for line in bounds(rows)), ""]
