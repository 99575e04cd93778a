"""Figures 4 and 5 of Morillo et al. 2015 as measured here, and list builds by distribution, as SVG and PNG."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

Row = dict[str, str]

#: Colors of Okabe and Ito, which people with color-blindness tell apart, and a marker for each search.
METHODS = {
    "standard": ("#000000", "s"),
    "octant": ("#D55E00", "o"),
    "trimmed": ("#0072B2", "^"),
    "midplane": ("#009E73", "D"),
}

#: Line of an edge, in neighbor cutoffs R.
DASHES = {
    0.5: (0, (1, 3)),
    1.0: (0, (1, 1)),
    2.0: "-",
    2.52: (0, (5, 2)),
    4.0: (0, (5, 2, 1, 2)),
}

#: Directions of figure 4 that a line of its own shows, each from the own cell on.
DIRECTIONS = {"X": ("#D55E00", "o"), "Y": ("#0072B2", "s"), "Z": ("#009E73", "^")}


def write(folder: Path) -> list[Path]:
    """Draws every file of the folder; the paths of what it wrote."""
    plt.rcParams.update(
        {"font.size": 9, "svg.hashsalt": "octant", "axes.spines.top": False, "axes.spines.right": False}
    )
    draw: dict[str, Callable[[Sequence[Row]], Figure]] = {
        "figure4": figure_4,
        "figure5": figure_5,
        "distributions": distributions,
    }
    rows = {name: read(folder / f"{name}.csv") for name in draw}
    written = []
    for name, drawn in draw.items():
        figure = drawn(rows[name])
        for path, options in (
            (folder / f"{name}.png", {"dpi": 150}),
            (folder / f"{name}.svg", {"metadata": {"Date": None}}),
        ):
            figure.savefig(path, **options)
            written.append(path)
        plt.close(figure)
    return written


def read(path: Path) -> list[Row]:
    """Rows of a file, cells by column."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def figure_4(rows: Sequence[Row]) -> Figure:
    """Time against adjacent cells: one direction alone on the left, X, Y and Z in turn on the right."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    own = [row for row in rows if row["direction"] == "own"]
    for direction, (color, marker) in DIRECTIONS.items():
        line = own + [row for row in rows if row["direction"] == direction]
        _line(left, line, "adjacent_cells", "list_us", color=color, marker=marker, label=direction)
    left.set_title("one direction alone", loc="left")
    left.legend(frameon=False)
    in_turn = own + [row for row in rows if row["direction"] in ("X", "XY", "XYZ")]
    _line(right, in_turn, "adjacent_cells", "list_us", color="#000000", marker="o")
    for row in in_turn:
        at = (float(row["adjacent_cells"]), float(row["list_us"]))
        right.annotate(row["block"], at, textcoords="offset points", xytext=(4, -10), fontsize=7, color="0.4")
    right.set_title("X, then Y, then Z", loc="left")
    for panel in (left, right):
        panel.set_xlabel(f"adjacent cells with {rows[0]['load']} particles each")
        panel.set_ylabel("µs a list, without the sort")
        panel.set_ylim(bottom=0)
        panel.grid(color="0.92", lw=0.6)
    figure.suptitle(f"Figure 4: {rows[0]['particles']} particles, {_place(rows)}", fontsize=9)
    return figure


def figure_5(rows: Sequence[Row]) -> Figure:
    """Time against the number of particles: what the paper compares on the left, all on the right."""
    figure, panels = plt.subplots(1, 2, figsize=(12, 5), layout="constrained", sharey=True)
    published = {"standard": (2.0, 2.52, 4.0), "octant": (2.0, 2.52, 4.0)}
    usual = {"standard": (0.5, 1.0, 2.0), "octant": (2.0,), "trimmed": (2.0, 2.52, 4.0), "midplane": (2.52, 4.0)}
    titles = ("the paper's searches and edges", "beside what it leaves out")
    for panel, chosen, title in zip(panels, (published, usual), titles, strict=True):
        for method, edges in chosen.items():
            color, marker = METHODS[method]
            for edge in edges:
                line = [row for row in rows if row["method"] == method and float(row["edge"]) == edge]
                look = {"color": color, "marker": marker, "ls": DASHES[edge], "label": f"{method}, {edge:g} R"}
                _line(panel, line, "particles", "build_us", **look)
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_xlabel("particles")
        panel.set_title(title, loc="left")
        panel.grid(color="0.92", lw=0.6)
        panel.legend(frameon=False, fontsize=7)
    panels[0].set_ylabel("µs a build, sort included")
    figure.suptitle(f"Figure 5: {_place(rows)}", fontsize=9)
    return figure


def distributions(rows: Sequence[Row]) -> Figure:
    """Time for each neighbor found, by search; a panel for each distribution, the sort's part in gray."""
    names = list(dict.fromkeys(row["distribution"] for row in rows))
    figure, panels = plt.subplots(1, len(names), figsize=(3.2 * len(names), 4.2), layout="constrained", sharey=True)
    for panel, name in zip(panels, names, strict=True):
        bars = [row for row in rows if row["distribution"] == name]
        labels = [row["search"] for row in bars]
        times = [float(row["list_ns_per_neighbor"]) for row in bars]
        sorts = [float(row["build_ns_per_neighbor"]) - time for row, time in zip(bars, times, strict=True)]
        panel.barh(labels, times, color=[METHODS[row["method"]][0] for row in bars])
        panel.barh(labels, sorts, left=times, color="0.75")
        panel.set_title(f"{name}: {bars[0]['particles']}", loc="left")
        panel.set_xlabel("ns a neighbor found (gray: sort)")
    panels[0].invert_yaxis()
    figure.suptitle(f"List builds by distribution: {_place(rows)}", fontsize=9)
    return figure


def _line(panel: Axes, rows: Sequence[Row], x: str, y: str, **look: object) -> None:
    """Medians, with bars from least to most."""
    points = sorted(rows, key=lambda row: float(row[x]))
    medians = [float(row[y]) for row in points]
    below = [median - float(row[f"{y}_least"]) for row, median in zip(points, medians, strict=True)]
    above = [float(row[f"{y}_most"]) - median for row, median in zip(points, medians, strict=True)]
    xs = [float(row[x]) for row in points]
    panel.errorbar(xs, medians, [below, above], ms=4, lw=1.1, elinewidth=0.8, **look)


def _place(rows: Sequence[Row]) -> str:
    return f"{rows[0]['backend']}, {rows[0]['device']}, {rows[0]['precision']} precision"
