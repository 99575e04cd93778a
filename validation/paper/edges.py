"""Claims 2 and 3: octant is faster than standard at equal edge, and cells of 2R are best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from validation.markdown import number, spaced, table
from validation.paper.claim import ALIKE, FAILS, HOLDS, PART, Claim
from validation.paper.results import Results, Row, Time, one, shapes, where

#: What the paper states: faster by so many percent, with cells of these edges (R), and the best of them.
GAIN = (85.0, 115.0)
EDGES = (2.0, 2.52, 4.0)
BEST = 2.0

#: The sort may be part of the paper's times or not, so everything is judged without it and with it.
PARTS = {"list_us": "the list alone", "build_us": "sort and list"}

#: What the opponent that the paper leaves out is compared with: how it is called, method and edge.
COMPARED = (
    ("octant, 2 R", "octant", 2.0),
    ("octant, 4 R", "octant", 4.0),
    ("mid-plane, 2.52 R", "midplane", 2.52),
    ("mid-plane, 4 R", "midplane", 4.0),
    ("trimmed, 2 R", "trimmed", 2.0),
    ("standard, R/2", "standard", 0.5),
)

#: How one time is to another.
WORDS = ("faster", "alike", "slower")

Pair = tuple[Time, Time]


def gain(results: Results) -> Claim:
    """Claim 2: octant is 85 to 115 % faster than standard with the same edge, figure 5."""
    lines, counted = [], []
    reached = [True] * len(results.sizes)
    for column, what in PARTS.items():
        times = {edge: _times(results, ("octant", edge), ("standard", edge), column) for edge in EDGES}
        gains = {edge: [octant.gain(standard) for octant, standard in pairs] for edge, pairs in times.items()}
        counted += [value for values in gains.values() for value in values]
        least = [min(values) for values in zip(*gains.values(), strict=True)]
        reached = [so_far and value >= GAIN[0] for so_far, value in zip(reached, least, strict=True)]
        cells = [[f"{edge:g} R", *(_percent(pair) for pair in pairs)] for edge, pairs in times.items()]
        lines += [
            f"Octant over standard at equal edge, {what}, by number of particles (≈: rounds of the two overlap):",
            "",
        ]
        lines += table(["edge", *map(spaced, results.sizes)], cells)
    below, above = sum(value < GAIN[0] for value in counted), sum(value > GAIN[1] for value in counted)
    inside = len(counted) - below - above
    lines += [
        f"Of {len(counted)} gains {inside} are within {GAIN[0]:g} to {GAIN[1]:g} %, {above} above, {below} below "
        f"({min(counted):.0f} to {max(counted):.0f} %, median {float(np.median(counted)):.0f} %). "
        + shapes(results.tables["figure5"])
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


def pairs(rows: Sequence[Row], a: tuple[str, float], b: tuple[str, float], column: str) -> dict[int, Pair]:
    """Times of two searches, each a method and an edge, by number of particles."""
    sizes = sorted({int(row["particles"]) for row in where(rows, method=a[0], edge=a[1])})

    def time(search: tuple[str, float], size: int) -> Time:
        return Time.of(one(rows, method=search[0], edge=search[1], particles=size), column)

    return {size: (time(a, size), time(b, size)) for size in sizes}


def _times(results: Results, a: tuple[str, float], b: tuple[str, float], column: str) -> list[Pair]:
    return list(pairs(results.tables["figure5"], a, b, column).values())


def _percent(pair: Pair) -> str:
    """By how much the first is faster, and whether the rounds can tell."""
    return f"{pair[0].gain(pair[1]):.0f} %" + (" ≈" if pair[0].alike(pair[1]) else "")


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
        f"standard {number(tests[0])}, {tests[0] / tests[1]:.2f} times as many, {cost}."
    )


def _opponents(results: Results) -> list[str]:
    """What the paper leaves out: the standard search with the edge it is usually run with, and octant's variants."""
    usual = {column: _times(results, ("octant", BEST), ("standard", 1.0), column) for column in PARTS}
    said = "; ".join(f"{what}: {_compared(results.sizes, usual[column])}" for column, what in PARTS.items())
    lines = [
        "Against the opponent that the paper leaves out, the standard search with cells of edge R, octant with edge "
        f"2R is faster, slower or alike (rounds of the two overlap: ≈). {said[0].upper()}{said[1:]}.",
        "",
    ]
    for column, what in PARTS.items():
        cells = []
        for name, method, edge in COMPARED:
            times = _times(results, (method, edge), ("standard", 1.0), column)
            cells.append([name, *(("+" if a.gain(b) > 0 else "") + _percent((a, b)) for a, b in times)])
        lines += table([f"faster than standard, R: {what}", *map(spaced, results.sizes)], cells)
    return lines[:-1]


def _compared(sizes: Sequence[int], times: Sequence[Pair]) -> str:
    """Where the first is faster, alike and slower, as far as the rounds can tell."""
    faster, alike, slower = WORDS
    words = [faster if a.beats(b) else slower if b.beats(a) else alike for a, b in times]
    if len(set(words)) == 1:
        return f"{words[0]} at every size"
    found = {word: [spaced(s) for s, w in zip(sizes, words, strict=True) if w == word] for word in WORDS}
    return ", ".join(f"{word} at {len(at)} of {len(sizes)} sizes ({'; '.join(at)})" for word, at in found.items() if at)


def edge(results: Results) -> Claim:
    """Claim 3: cells of edge 2R are best, figure 5."""
    text, own, rest = [], {}, {}
    octant_alone = True
    for column, what in PARTS.items():
        lines, good = [], {}
        for method, edges in (("octant", EDGES), ("standard", EDGES), ("standard", (0.5, 1.0, *EDGES))):
            name = f"{method}, all edges" if len(edges) > len(EDGES) else f"{method}, the paper's edges"
            best = [_best(results, method, edges, size, column) for size in results.sizes]
            lines.append([name, *(f"{first:g} R{' ≈' if tied else ''}" for first, tied in best)])
            good[name] = [first == BEST or tied for first, tied in best]
        *papers, rest[column] = good.values()
        own[column] = [fine for each in papers for fine in each]
        octant_alone &= all(papers[0])
        text += [
            f"The edge that is fastest, {what} (≈: rounds with 2R overlap with it), by number of particles:",
            "",
            *table(["search", *map(spaced, results.sizes)], lines),
        ]
    counts = {column: (sum(own[column]), len(own[column])) for column in PARTS}
    everything = [fine for column in PARTS for fine in own[column]]
    smaller = [fine for column in PARTS for fine in rest[column]]
    verdict = HOLDS if all(everything + smaller) else FAILS if not any(everything) else PART
    told = ", ".join(f"{what} {counts[column][0]} of {counts[column][1]}" for column, what in PARTS.items())
    below = ", ".join(f"{what} {sum(rest[column])} of {len(rest[column])}" for column, what in PARTS.items())
    short = f"among the paper's three edges 2R is best (or alike) in {sum(everything)} of {len(everything)} cases"
    size = results.sizes[-1]
    octants = {e: one(results.tables["figure5"], method="octant", particles=size, edge=e) for e in EDGES}
    tests = ", ".join(f"{number(float(row['tests_per_particle']))} at {e:g} R" for e, row in octants.items())
    text.append(
        f"{short[0].upper()}{short[1:]} ({told}); for the standard search with R/2 and R beside them in {sum(smaller)} "
        f"of {len(smaller)} ({below}). Octant's distance tests a particle grow with the volume of the cells ({tests}, "
        f"{spaced(size)} particles); smaller than 2R its cells cannot be. The standard search can go below, where its "
        "tests fall further. "
        + ("" if octant_alone else "Where larger cells win all the same, it is not for fewer tests. ")
        + shapes(results.tables["figure5"])
    )
    text[-1] = text[-1].rstrip()
    return Claim(verdict, f"{short}, for standard with smaller ones too in {sum(smaller)} of {len(smaller)}", text)


def _best(results: Results, method: str, edges: Sequence[float], size: int, column: str) -> tuple[float, bool]:
    """The edge with the shortest median, and whether 2R, another one, is as good for all that the rounds can tell."""
    rows = where(results.tables["figure5"], method=method, particles=size)
    times = {e: Time.of(one(rows, edge=e), column) for e in edges}
    first = min(times, key=lambda e: times[e].median)
    return first, first != BEST and times[first].alike(times[BEST])
