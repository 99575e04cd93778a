"""Claim 1: the order X, Y, Z and the plain hash keep data together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from validation.markdown import number, spaced, table
from validation.paper.claim import ALIKE, FAILS, HOLDS, PART, Claim, span, timed
from validation.paper.results import Results, Row, Time, one, shapes, where

#: What is alike, or straight, as far as the noise lets it be seen, and what is for sure.
NOISE = {word: (f"{word} within the noise", word) for word in ("direction-free", "linear")}

#: Who keeps neighbors closer in memory, in the words of the verdict.
CLOSER = {
    1: "neighbors lie closer in memory than along a Z-order curve",
    -1: "a Z-order curve keeps neighbors closer",
    0: "whether a Z-order curve keeps neighbors closer depends on what is counted",
}


@dataclass(frozen=True)
class Fit:
    """The straight line through the times of figure 4, and how much of their differences it explains."""

    slope: float
    begin: float
    squared: float

    @classmethod
    def through(cls, rows: Sequence[Row]) -> Fit:
        """Least squares, every point alike."""
        x, y = (np.array([float(row[name]) for row in rows]) for name in ("adjacent_cells", "list_us"))
        slope, begin = np.polyfit(x, y, 1)
        left, all_of_it = ((y - begin - slope * x) ** 2).sum(), ((y - y.mean()) ** 2).sum()
        return cls(float(slope), float(begin), float(1 - left / all_of_it) if all_of_it else 1.0)

    def at(self, adjacent: float) -> float:
        """Time with so many adjacent cells."""
        return self.begin + self.slope * adjacent


def in_turn(rows: Sequence[Row]) -> list[Row]:
    """Rows of figure 4 that add X, then Y, then Z."""
    chosen = [row for row in rows if row["direction"] in ("own", "X", "XY", "XYZ")]
    return sorted(chosen, key=lambda row: int(row["adjacent_cells"]))


def order(results: Results) -> Claim:
    """Judged by figure 4, and by a Z-order curve beside the rows."""
    rows = results.tables["figure4"]
    lines = _cells(rows)
    free, direction = _directions(rows)
    straight, line = _line(in_turn(rows))
    closer, faster, against = _curve(results)
    lines += [direction, "", line, "", *against]
    parts = [bool(free), bool(straight), closer > 0, faster]
    verdict = HOLDS if all(parts) else PART if any(parts) else FAILS
    join = "but" if closer and (closer > 0) != faster else "and"
    words = (
        f"{free or 'not direction-free'}, {straight or 'not linear'}; {CLOSER[closer]}, "
        f"{join} builds along {'it' if closer else 'one'} are {'no faster' if faster else 'faster'}"
    )
    means = (
        "and that no direction differs says that distance in memory does not matter at this size, not that it is small."
        if free
        else "and directions that differ, with equal loads, speak for distance in memory that does matter."
    )
    lines += [
        "What figure 4 cannot show is the cause: time that is linear in the cells searched is what any order gives "
        f"whose cells cost alike, {means}",
    ]
    return Claim(verdict, words, lines)


def _cells(rows: Sequence[Row]) -> list[str]:
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
    heads = ["cells searched", "adjacent cells", "tests", "neighbors", "µs a list (least to most)", "ns a test"]
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


def _line(turn: Sequence[Row]) -> tuple[str, str]:
    """What the line is if it is straight, and how far from that."""
    fit = Fit.through(turn)
    times = [Time.of(row, "list_us") for row in turn]
    drawn = [fit.at(float(row["adjacent_cells"])) for row in turn]
    off = [abs(time.median - at) / time.median for time, at in zip(times, drawn, strict=True)]
    # On the line, or as near to it as the rounds can tell.
    between = [time.least <= at <= time.most for time, at in zip(times, drawn, strict=True)]
    straight = all(o <= ALIKE or b for o, b in zip(off, between, strict=True))
    text = (
        f"X, then Y, then Z: a straight line with {number(fit.slope)} µs for each adjacent cell (R² = "
        f"{fit.squared:.3f}); what is measured is up to {100 * max(off):.0f} % away from it ({sum(between)} of "
        f"{len(turn)} points have it between their shortest and longest round). "
    )
    found = [float(row["neighbors"]) / float(row["tests_per_particle"]) for row in (turn[0], turn[-1])]
    text += (
        f"Of the tests in the own cell {100 * found[0]:.0f} % find a neighbor, of those in all 27 cells "
        f"{100 * found[1]:.0f} %."
    )
    return NOISE["linear"][max(off) <= ALIKE] if straight else "", text


def _curve(results: Results) -> tuple[int, bool, list[str]]:
    """Who keeps neighbors closer (1: rows, -1: the curve, 0: measures differ), whether rows are as fast, and the text."""
    rows = where(results.tables["orders"], sort="counting")
    pairs = [
        (row, one(rows, order="zorder", **{name: row[name] for name in ("method", "edge", "particles")}))
        for row in where(rows, order="rows")
    ]
    sorts, lists, builds = (
        [float(curve[column]) / float(plain[column]) for plain, curve in pairs]
        for column in ("sort_us", "list_us", "build_us")
    )
    times = [(Time.of(plain, "build_us"), Time.of(curve, "build_us")) for plain, curve in pairs]
    beaten = sum(curve.beats(plain) for plain, curve in times)
    beats = sum(plain.beats(curve) for plain, curve in times)
    largest = max(int(plain["particles"]) for plain, _ in pairs)
    at_largest = [(plain, curve) for plain, curve in pairs if int(plain["particles"]) == largest]
    closer, told = _closer(at_largest)
    median = float(np.median(builds))
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
        f"sizes: along the curve the sort takes {span(sorts)} times as long, the list {span(lists)}, both "
        f"{span(builds)} (median {median:.2f}). In every round the curve was faster in {beaten} of them, rows in "
        f"{beats}. {shapes(rows)}With {spaced(largest)} particles (between neighbors: particles in memory from one to "
        "the other, the middle one of all pairs, and pairs with more than 4096, 64 KiB of f32 coordinates):"
    )
    lines = [text, "", *table(heads, cells), told, "", *_bricks(rows), *_filling(results, pairs)]
    return closer, median >= 1 - ALIKE, lines


def _bricks(rows: Sequence[Row]) -> list[str]:
    """The order that an engine has where none is asked for, beside rows, if it is another one."""
    names = ("method", "edge", "particles")
    pairs = [(row, one(rows, order="rows", **{name: row[name] for name in names})) for row in where(rows, order="bricks")]
    if not pairs:
        return []
    lists, builds = (
        [float(brick[column]) / float(plain[column]) for brick, plain in pairs] for column in ("list_us", "build_us")
    )
    return [
        "This engine's own order, brick after brick of 2 x 2 x 2 cells, beside rows: the list takes "
        f"{span(lists)} times as long, sort and list {span(builds)} (median {float(np.median(builds)):.2f}).",
        "",
    ]


def _closer(pairs: Sequence[tuple[Row, Row]]) -> tuple[int, str]:
    """What both measures of all searches say together, and what each says."""
    signs = {
        name: [math.copysign(1, by) if (by := float(curve[name]) - float(plain[name])) else 0 for plain, curve in pairs]
        for name in ("apart", "far_percent")
    }
    of, along = len(pairs), {name: sum(sign < 0 for sign in found) for name, found in signs.items()}
    rows = {name: sum(sign > 0 for sign in found) for name, found in signs.items()}
    told = (
        f"By the middle distance neighbors are closer along rows in {rows['apart']} of {of} searches, along the curve "
        f"in {along['apart']}; by the pairs far apart along rows in {rows['far_percent']}, along the curve in "
        f"{along['far_percent']}."
    )
    said = {sign for found in signs.values() for sign in found if sign}
    # Without any difference rows are as good.
    closer = int(next(iter(said), 1)) if len(said) < 2 else 0
    return closer, told if closer else f"{told} The two do not agree, so neither order is called the closer one."


def _filling(results: Results, pairs: Sequence[tuple[Row, Row]]) -> list[str]:
    """Ratios beside how much of the cube that the curve numbers holds cells of the grid."""
    sides = {int(row["particles"]): float(row["edge"]) for row in results.tables["table1"]}
    sizes = sorted({int(plain["particles"]) for plain, _ in pairs})
    cells: dict[str, list[str]] = {}
    ratios: dict[bool, list[list[float]]] = {True: [], False: []}
    for plain, curve in sorted(pairs, key=lambda pair: int(pair[0]["particles"])):
        ratio = [float(curve[column]) / float(plain[column]) for column in ("sort_us", "list_us")]
        side = _side(plain) or sides.get(int(plain["particles"]))
        cell = "{:.2f}, {:.2f}".format(*ratio)
        if side is not None:
            part = filled(side, float(plain["edge"]))
            ratios[part < 0.5].append(ratio)
            cell += f" ({100 * part:.0f} %)"
        cells.setdefault(plain["search"], []).append(cell)
    lines = [
        "The curve numbers the cells of a cube with a power of two of them along each side, the smallest that holds the "
        "grid; what is not filled are numbers without a cell, which a table of all of them has places for and which a "
        "sort by counting goes through. Times along the curve over those in rows, sort and list, and in brackets how "
        "much of the cube is filled by the cells that cover the box:",
        "",
        *table(["search", *map(spaced, sizes)], [[name, *row] for name, row in cells.items()]),
    ]
    said = [
        f"where {where_} is filled ({len(found)} cases) the sort takes {np.median([r[0] for r in found]):.2f} times as long in the "
        f"middle, the list {np.median([r[1] for r in found]):.2f}"
        for where_, found in (
            ("less than half", ratios[True]),
            ("half or more", ratios[False]),
        )
        if found
    ]
    whole = "; ".join(said)
    return [*lines, f"{whole[:1].upper()}{whole[1:]}.", ""] if said else lines


def _side(row: Row) -> float | None:
    """Largest side of the box in neighbor cutoffs; files of earlier versions do not tell it."""
    return max(map(float, row["box"].split())) / float(row["radius"]) if "box" in row else None


def filled(side: float, edge: float) -> float:
    """Part of the curve's cube that is filled by the cells of this edge that cover a box of this side."""
    cells = math.ceil(side / edge)
    return (cells / 2 ** math.ceil(math.log2(cells))) ** 3
