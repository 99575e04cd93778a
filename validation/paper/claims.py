"""The paper's three claims, judged by what was measured: numbers and turns of the text come from the rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from validation.markdown import number, spaced, table
from validation.paper.results import Results, Row, Time, one, where

HOLDS, PART, FAILS = "holds", "holds in part", "fails"

#: What the paper states: faster by so many percent, with cells of these edges (R), and the best of them.
GAIN = (85.0, 115.0)
EDGES = (2.0, 2.52, 4.0)
BEST = 2.0

#: A line is called straight where nothing measured is further from it than this part of itself, and two things alike
#: where they differ by no more.
ALIKE = 0.10

#: What is alike, or straight, as far as the noise lets it be seen, and what is for sure.
NOISE = {word: (f"{word} within the noise", word) for word in ("direction-free", "linear")}


@dataclass(frozen=True)
class Claim:
    """A claim, what became of it in a few words, and why."""

    verdict: str
    short: str
    lines: list[str]


def judge(results: Results) -> list[Claim]:
    """The three claims in the paper's order."""
    return [order(results), gain(results), edge(results)]


def order(results: Results) -> Claim:
    """Claim 1: the order X, Y, Z and the plain hash keep data together, shown by figure 4."""
    rows = results.tables["figure4"]
    lines = _blocks(rows)
    free, direction = _directions(rows)
    straight, line = _line(rows)
    closer, faster, against = _curve(results)
    lines += [direction, "", line, "", *against]
    parts = [bool(free), bool(straight), closer, faster]
    verdict = HOLDS if all(parts) else PART if any(parts) else FAILS
    words = f"{free or 'not direction-free'}, {straight or 'not linear'}; "
    words += (
        "neighbors lie closer in memory than along a Z-order curve, "
        if closer
        else "a Z-order curve keeps neighbors closer, "
    )
    join = "and" if closer == faster else "but"
    words += f"{join} builds along it are {'no faster' if faster else 'faster'}"
    means = (
        "and that no direction differs says that distance in memory does not matter at this size, not that it is small."
        if free
        else "and directions that differ, with equal loads, speak for distance in memory that does matter."
    )
    lines += [
        "",
        "What figure 4 cannot show is the cause: time that is linear in the cells searched is what any order gives "
        f"whose cells cost alike, {means}",
    ]
    return Claim(verdict, words, lines)


def _blocks(rows: Sequence[Row]) -> list[str]:
    cells = [
        [
            row["block"],
            row["adjacent_cells"],
            row["tests_per_particle"],
            number(float(row["neighbors"])),
            timed(Time.of(row, "list_us")),
            number(1e3 * float(row["list_us"]) / (int(row["particles"]) * float(row["tests_per_particle"]))),
        ]
        for row in rows
    ]
    heads = ["cells of a block", "adjacent cells", "tests", "neighbors", "µs a list (least to most)", "ns a test"]
    return table(heads, cells)


def _directions(rows: Sequence[Row]) -> tuple[str, str]:
    """What the directions are if they are alike, and how far they are apart."""
    said, free, sure = [], True, True
    for adjacent in (1, 2):
        times = {axis: Time.of(one(rows, direction=axis, adjacent_cells=adjacent), "list_us") for axis in "XYZ"}
        medians = {axis: time.median for axis, time in times.items()}
        apart = max(medians.values()) / min(medians.values()) - 1
        slow, quick = (pick(medians, key=lambda axis: medians[axis]) for pick in (max, min))
        overlap = not times[quick].beats(times[slow])
        free &= overlap or apart <= ALIKE
        sure &= apart <= ALIKE
        plural = "cell" if adjacent == 1 else "cells"
        rounds = (
            "rounds of all three overlap" if overlap else f"no round of {slow} was as short as the longest of {quick}"
        )
        said.append(f"With {adjacent} adjacent {plural} the three directions are {100 * apart:.0f} % apart ({rounds}).")
    return NOISE["direction-free"][sure] if free else "", " ".join(said)


def _line(rows: Sequence[Row]) -> tuple[str, str]:
    """What the line is if it is straight, and how far from that."""
    turn = [one(rows, direction="own"), one(rows, direction="X", adjacent_cells=2)]
    turn += [row for row in rows if row["direction"] in ("XY", "XYZ")]
    x = np.array([float(row["adjacent_cells"]) for row in turn])
    y = np.array([float(row["list_us"]) for row in turn])
    slope, begin = np.polyfit(x, y, 1)
    off = np.abs(y - (begin + slope * x)) / y
    squared = 1 - ((y - (begin + slope * x)) ** 2).sum() / ((y - y.mean()) ** 2).sum()
    # On the line, or as near to it as the rounds can tell.
    times = [Time.of(row, "list_us") for row in turn]
    between = [time.least <= at <= time.most for time, at in zip(times, begin + slope * x, strict=True)]
    straight = all(o <= ALIKE or b for o, b in zip(off, between, strict=True))
    text = (
        f"X, then Y, then Z: a straight line with {number(slope)} µs for each adjacent cell (R² = {squared:.3f}); what "
        "is measured "
        f"is up to {100 * off.max():.0f} % away from it ({sum(between)} of {len(turn)} points have it between their "
        "shortest "
        "and longest round). "
    )
    found = [float(row["neighbors"]) / float(row["tests_per_particle"]) for row in (turn[0], turn[-1])]
    text += (
        f"Of the tests in the own cell {100 * found[0]:.0f} % find a neighbor, of those in all 27 cells "
        f"{100 * found[1]:.0f} %."
    )
    return NOISE["linear"][bool(off.max() <= ALIKE)] if straight else "", text


def _curve(results: Results) -> tuple[bool, bool, list[str]]:
    rows = where(results.tables["orders"], sort="counting")
    pairs = [
        (row, one(rows, search=f"{row['search']}+zorder", particles=int(row["particles"])))
        for row in where(rows, order="rows")
    ]
    lists = [float(curve["list_us"]) / float(plain["list_us"]) for plain, curve in pairs]
    sorts = [float(curve["sort_us"]) / float(plain["sort_us"]) for plain, curve in pairs]
    builds = [float(curve["build_us"]) / float(plain["build_us"]) for plain, curve in pairs]
    beaten = sum(Time.of(curve, "build_us").beats(Time.of(plain, "build_us")) for plain, curve in pairs)
    beats = sum(Time.of(plain, "build_us").beats(Time.of(curve, "build_us")) for plain, curve in pairs)
    largest = max(int(plain["particles"]) for plain, _ in pairs)
    at_largest = [(plain, curve) for plain, curve in pairs if int(plain["particles"]) == largest]
    closer = all(float(plain["far_percent"]) <= float(curve["far_percent"]) for plain, curve in at_largest)
    median = float(np.median(builds))
    faster = median >= 1 - ALIKE
    cells = [
        [
            plain["search"],
            *(f"{number(float(row['apart']))}, {float(row['far_percent']):.0f} %" for row in (plain, curve)),
            *(timed(Time.of(row, "build_us")) for row in (plain, curve)),
        ]
        for plain, curve in at_largest
    ]
    heads = ["search", "rows: between neighbors", "curve: between neighbors", "rows: µs a build", "curve: µs a build"]
    text = (
        f"Beside a Z-order curve, which the paper turns down without a number, over {len(pairs)} pairs of searches and "
        "sizes: along "
        f"the curve the sort takes {_range(sorts)} times as long, the list {_range(lists)}, both {_range(builds)} "
        "(median "
        f"{median:.2f}). In every round the curve was faster in {beaten} of them, rows in {beats}. With "
        f"{spaced(largest)} particles "
        "(between neighbors: particles in memory from one to the other, the middle one of all pairs, and pairs with "
        "more than 4096, "
        "64 KiB of f32 coordinates):"
    )
    return closer, faster, [text, "", *table(heads, cells)]


def gain(results: Results) -> Claim:
    """Claim 2: octant is 85 to 115 % faster than standard with the same edge, figure 5."""
    lines, counted = [], []
    reached = [True] * len(results.sizes)
    for column, what in (("list_us", "the list alone"), ("build_us", "sort and list")):
        gains = {edge: _gains(results, "octant", edge, "standard", edge, column) for edge in EDGES}
        counted += [value for values in gains.values() for value in values]
        least = [min(values) for values in zip(*gains.values(), strict=True)]
        reached = [so_far and value >= GAIN[0] for so_far, value in zip(reached, least, strict=True)]
        cells = [[f"{edge:g} R", *(f"{value:.0f} %" for value in values)] for edge, values in gains.items()]
        lines += [f"Octant over standard at equal edge, {what}, by number of particles:", ""]
        lines += table(["edge", *map(spaced, results.sizes)], cells)
    below, above = sum(value < GAIN[0] for value in counted), sum(value > GAIN[1] for value in counted)
    inside = len(counted) - below - above
    lines += [
        f"Of {len(counted)} gains {inside} are within {GAIN[0]:g} to {GAIN[1]:g} %, {above} above, {below} below "
        f"({min(counted):.0f} to {max(counted):.0f} %, median {float(np.median(counted)):.0f} %). "
        + _from(results, reached)
        + _why(results),
        "",
        *_opponents(results),
    ]
    verdict = HOLDS if below == 0 else FAILS if below == len(counted) else PART
    short = (
        f"{min(counted):.0f} to {max(counted):.0f} %; of {len(counted)} gains {inside} within the range, {above} above"
    )
    return Claim(verdict, f"{short}, {below} below", lines)


def _gains(results: Results, a: str, edge_a: float, b: str, edge_b: float, column: str = "build_us") -> list[float]:
    """Percentage by which one search is faster than another, by size."""
    rows = results.tables["figure5"]

    def time(method: str, edge: float, size: int) -> Time:
        return Time.of(one(rows, method=method, edge=edge, particles=size), column)

    return [time(a, edge_a, size).gain(time(b, edge_b, size)) for size in results.sizes]


def _from(results: Results, reached: Sequence[bool]) -> str:
    """From which size on every gain is as large as is claimed."""
    sizes = [size for k, size in enumerate(results.sizes) if all(reached[k:])]
    if not sizes:
        return f"At the largest size some gain is below {GAIN[0]:g} %. "
    return f"From {spaced(sizes[0])} particles on every gain is at least {GAIN[0]:g} %. "


def _why(results: Results) -> str:
    size = results.sizes[-1]
    rows = where(results.tables["figure5"], particles=size, edge=BEST)
    standard, octant = one(rows, method="standard"), one(rows, method="octant")
    tests = [float(row["tests_per_particle"]) for row in (standard, octant)]
    each = [1e3 * float(row["list_us"]) / (size * count) for row, count in zip((standard, octant), tests, strict=True)]
    dearer = each[1] / each[0]
    cost = (
        f"but one test of octant's costs {dearer:.2f} times as much, both writing down the same neighbors"
        if dearer > 1 + ALIKE
        else "and a test costs the same in both"
        if dearer > 1 - ALIKE
        else f"and one test of octant's costs {dearer:.2f} times as much"
    )
    return (
        f"With {spaced(size)} particles and edge 2R octant makes {number(tests[1])} distance tests a particle, "
        "standard "
        f"{number(tests[0])}, {tests[0] / tests[1]:.2f} times as many, {cost}."
    )


def _opponents(results: Results) -> list[str]:
    """What the paper leaves out: the standard search with the edge it is usually run with, and octant's variants."""
    usual = _gains(results, "octant", BEST, "standard", 1.0)
    word = (
        "faster at every size"
        if min(usual) > 0
        else "slower at every size"
        if max(usual) < 0
        else "faster at some sizes only"
    )
    lines = [
        "Against the opponent that the paper leaves out, the standard search with cells of edge R, octant with edge "
        f"2R is {word}:",
        "",
    ]
    compared = [
        ("octant, 2 R", "octant", 2.0),
        ("octant, 4 R", "octant", 4.0),
        ("mid-plane, 2.52 R", "midplane", 2.52),
        ("mid-plane, 4 R", "midplane", 4.0),
        ("trimmed, 2 R", "trimmed", 2.0),
        ("standard, R/2", "standard", 0.5),
    ]
    cells = [
        [name, *(f"{value:+.0f} %" for value in _gains(results, method, edge, "standard", 1.0))]
        for name, method, edge in compared
    ]
    return lines + table(["faster than standard, R", *map(spaced, results.sizes)], cells)


def edge(results: Results) -> Claim:
    """Claim 3: cells of edge 2R are best, figure 5."""
    lines, verdicts = [], {}
    for method, edges in (("octant", EDGES), ("standard", EDGES), ("standard", (0.5, 1.0, *EDGES))):
        wide = len(edges) > len(EDGES)
        name = f"{method}, all edges" if wide else f"{method}, the paper's edges"
        best, tied = [], []
        for size in results.sizes:
            rows = where(results.tables["figure5"], method=method, particles=size)
            times = {e: Time.of(one(rows, edge=e), "build_us") for e in edges}
            first = min(times, key=lambda e: times[e].median)
            best.append(first)
            tied.append(first != BEST and not times[first].beats(times[BEST]))
        verdicts[name] = [b == BEST or t for b, t in zip(best, tied, strict=True)]
        lines.append([name, *(f"{b:g} R{' ?' if t else ''}" for b, t in zip(best, tied, strict=True))])
    text = [
        "The edge whose builds are fastest (sort and list; ?: some rounds with 2R were as fast), by number of "
        "particles:",
        "",
        *table(["search", *map(spaced, results.sizes)], lines),
    ]
    own = verdicts["octant, the paper's edges"] + verdicts["standard, the paper's edges"]
    rest = verdicts["standard, all edges"]
    verdict = HOLDS if all(own + rest) else FAILS if not any(own) else PART
    short = f"among the paper's three edges 2R is best (or as good) in {sum(own)} of {len(own)} cases"
    text.append(
        short[0].upper()
        + short[1:]
        + f"; for the standard search with R/2 and R beside them in {sum(rest)} of {len(rest)}. "
    )
    size = results.sizes[-1]
    octants = {e: one(results.tables["figure5"], method="octant", particles=size, edge=e) for e in EDGES}
    tests = ", ".join(f"{number(float(row['tests_per_particle']))} at {e:g} R" for e, row in octants.items())
    text[-1] += (
        f"Octant's distance tests a particle grow with the volume of the cells ({tests}, {spaced(size)} particles); "
        "smaller than "
        "2R its cells cannot be. The standard search can go below, where its tests fall further."
    )
    if verdicts["octant, the paper's edges"] != [True] * len(results.sizes):
        text[-1] += " Where larger cells win all the same, it is not for fewer tests."
    return Claim(verdict, f"{short}, for standard with smaller ones too in {sum(rest)} of {len(rest)}", text)


def timed(time: Time) -> str:
    """Median, and in brackets least and most."""
    return f"{number(time.median)} ({number(time.least)} to {number(time.most)})"


def _range(values: Sequence[float]) -> str:
    return f"{min(values):.2f} to {max(values):.2f}"
