"""The page with the verdict, from the CSV files of one run or several."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from validation.markdown import number, spaced, table
from validation.octant_runner import ROOT
from validation.paper import claims, system
from validation.paper.claims import Claim
from validation.paper.results import Results, Time, by_radix, one, where

PAPER = (
    "Morillo, Carmona, Perea and Cordero, *A More Efficient Parallel Method For Neighbour Search Using CUDA*, VRIPHYS "
    "2015, "
    "[doi:10.2312/vriphys.20151339](https://doi.org/10.2312/vriphys.20151339)"
)

ERRATA = ROOT / "validation" / "paper-errata.md"

TITLES = (
    "1: the order X, Y, Z and a plain hash cut the dispersion of data",
    "2: octant is 85 to 115 % faster than standard at equal edge",
    "3: cells of edge 2R are best",
)


def write(runs: Sequence[Results], path: Path) -> None:
    """Writes the page; figures are linked from where it lies."""
    path.write_text(page(runs, path.parent), encoding="utf-8")


def page(runs: Sequence[Results], folder: Path) -> str:
    """The page as Markdown."""
    judged = [claims.judge(results) for results in runs]
    lines = [
        "# The paper, rerun",
        "",
        f"{PAPER}, is what octant's neighbor search is built on. `make paper` reruns its experiments and those it "
        "leaves out, on the CPU and on the GPU "
        "where there is one; this page and its figures are written from the CSV files (`python -m validation.paper "
        "FOLDER`). "
        "R is the influence radius; times are medians over rounds in turns, with the shortest and the longest in "
        "brackets. What is printed "
        f"wrong in the paper has [a page of its own]({_relative(ERRATA, folder)}).",
        "",
        "## Verdict",
        "",
        *_summary(runs, judged),
        *_untested(),
        "## The system",
        "",
        *_agreement(runs),
        "### Neighbors: Table 1",
        "",
        *system.table_1(runs[0]),
        *system.later(runs[0]),
        "### The paper's step",
        "",
        *_figure(runs[0], "stability", "Growth of the energy a step against the timestep", folder),
        *system.stability(runs[0]),
    ]
    for results, three in zip(runs, judged, strict=True):
        lines += [f"## Search: {results.engine}", "", *_noise(results), *_figures(results, folder)]
        for title, claim in zip(TITLES, three, strict=True):
            lines += [f"### Claim {title}", "", f"**{_capital(claim.verdict)}**: {claim.short}.", "", *claim.lines, ""]
        lines += [f"### Beyond the paper: {results.engine}", "", *_beyond(results)]
    return "\n".join(lines).rstrip() + "\n"


def _summary(runs: Sequence[Results], judged: Sequence[Sequence[Claim]]) -> list[str]:
    cells = []
    for k, title in enumerate(TITLES):
        cells.append([title, *(f"**{three[k].verdict}**: {three[k].short}" for three in judged)])
    heads = ["claim", *(results.engine for results in runs)]
    return [*("| " + " | ".join(line) + " |" for line in (heads, ["---"] * len(heads), *cells)), ""]


def _agreement(runs: Sequence[Results]) -> list[str]:
    """Whose numbers stand here, and whether others have the same."""
    first, *others = runs
    lines = [f"Measured on {first.engine}; energies in double precision."]

    def counts(results: Results) -> dict[tuple[str, str], str]:
        return {(row["particles"], row["seeds"]): row["neighbors"] for row in results.tables["table1"]}

    for other in others:
        shared = counts(first).keys() & counts(other).keys()
        same = sum(counts(first)[key] == counts(other)[key] for key in shared)
        lines.append(
            f"Of {len(shared)} counts at step 0 that {other.engine} has of the same seeds {same} are the same."
        )
    return [" ".join(lines), ""]


def _untested() -> list[str]:
    return [
        "What cannot be tested: the paper's times themselves (a GTX 780 of 2013 and code that was not published; "
        "figures 4 and 5 are "
        "pictures without numbers), whether the sort is part of them (so both are given here), how its particles were "
        "spread, in which box, "
        "with which R, and at which step its neighbors were counted.",
        "",
    ]


def _noise(results: Results) -> list[str]:
    """What was noted of the run (``note.md`` in its folder), and how far the rounds of a time are apart."""
    times = [Time.of(row, "build_us") for row in results.tables["figure5"]]
    apart = sorted(100 * (time.most / time.least - 1) for time in times)
    rounds = int(results.tables["figure5"][0]["rounds"])
    note = results.folder / "note.md"
    noise = (
        f"The longest of {rounds} rounds is {apart[len(apart) // 2]:.0f} % longer than the shortest for half of the "
        f"times of figure 5, {apart[-1]:.0f} % at worst"
        + ("; differences that are smaller mean nothing." if apart[len(apart) // 2] > 10 else ".")
    )
    return [
        *([note.read_text(encoding="utf-8").strip(), ""] if note.is_file() else []),
        *([" ".join(results.cut), ""] if results.cut else []),
        f"{spaced(results.sizes[0])} to {spaced(results.sizes[-1])} particles. "
        + (noise if rounds > 1 else "With one round each, nothing tells a difference from noise."),
        "",
    ]


def _figures(results: Results, folder: Path) -> list[str]:
    shown = (
        ("figure4", "Figure 4: time against adjacent cells"),
        ("figure5", "Figure 5: time against the number of particles"),
        ("orders", "Order of cells and sort"),
        ("distributions", "List builds by distribution"),
    )
    return [line for name, what in shown for line in _figure(results, name, what, folder)]


def _figure(results: Results, name: str, what: str, folder: Path) -> list[str]:
    return [f"![{what}]({_relative(results.folder / f'{name}.svg', folder)})", ""]


def _relative(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path, folder)).as_posix()


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]


def _beyond(results: Results) -> list[str]:
    return [*_sizes(results), *_sorts(results), *_exhaustive(results), *_distributions(results)]


def _sizes(results: Results) -> list[str]:
    heads = ["particles", "search", "tests", "hits, %", "bytes", "sort, %", "ns a neighbor, list", "with the sort"]
    cells = []
    for size in (results.sizes[0], results.sizes[-1]):
        for row in results.rows("figure5", particles=size):
            share = 100 * float(row["sort_us"]) / float(row["build_us"])
            cells.append(
                [
                    spaced(size),
                    row["search"],
                    number(float(row["tests_per_particle"])),
                    f"{100 * float(row['hit_ratio']):.1f}",
                    number(float(row["bytes_per_particle"])),
                    f"{share:.0f}",
                    number(float(row["list_ns_per_neighbor"])),
                    number(float(row["build_ns_per_neighbor"])),
                ]
            )
    return ["Distance tests a particle, memory, and time for each neighbor found:", "", *table(heads, cells)]


def _sorts(results: Results) -> list[str]:
    rows = results.tables["orders"]
    radix = by_radix(rows)
    if not radix:
        return ["No sort by radix was measured here.", ""]
    cells: dict[str, list[str]] = {}
    ratios = []
    for row, counting in radix:
        name = counting["search"]
        ratios.append(float(row["sort_us"]) / float(counting["sort_us"]))
        cells.setdefault(name, []).append(f"{ratios[-1]:.2f}")
    sizes = sorted({int(row["particles"]) for row, _ in radix})
    slower, middle = sum(ratio > 1 for ratio in ratios), sorted(ratios)[len(ratios) // 2]
    return [
        f"A radix sort, which the paper takes, over counting: slower in {slower} of {len(ratios)} cases, "
        f"{min(ratios):.2f} to "
        f"{max(ratios):.2f} times as long, {middle:.2f} in the middle. Particles come in the order of the last build, "
        "as they do in a "
        "run; the time is that of the whole sort, wrapping and copying of particles included:",
        "",
        *table(["search", *map(spaced, sizes)], [[name, *times] for name, times in cells.items()]),
    ]


def _exhaustive(results: Results) -> list[str]:
    ratios = []
    for row in results.rows("figure5", method="brute"):
        best = one(results.tables["figure5"], search="trimmed", particles=int(row["particles"]))
        ratios.append((int(row["particles"]), float(row["build_us"]) / float(best["build_us"])))
    said = ", ".join(f"{ratio:.1f} at {spaced(size)}" for size, ratio in ratios)
    return (
        [f"The exhaustive search takes so many times as long as the trimmed one: {said} particles.", ""]
        if ratios
        else []
    )


def _distributions(results: Results) -> list[str]:
    rows = results.tables["distributions"]
    cells = []
    for name in dict.fromkeys(row["distribution"] for row in rows):
        of = sorted(where(rows, distribution=name), key=lambda row: float(row["build_us"]))
        fastest, usual = of[0], one(of, search="standard")
        octant = one(of, search="octant")
        cells.append(
            [
                name,
                spaced(int(fastest["particles"])),
                number(float(fastest["neighbors"])),
                fastest["search"],
                *(number(float(row["build_ns_per_neighbor"])) for row in (fastest, octant, usual)),
            ]
        )
    heads = [
        "distribution",
        "particles",
        "neighbors",
        "fastest search",
        "its ns a neighbor",
        "octant, 2 R",
        "standard, R",
    ]
    return ["Other distributions, sort included:", "", *table(heads, cells)]
