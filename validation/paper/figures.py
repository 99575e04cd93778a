"""Figures 4 and 5 of Morillo et al. 2015 as measured here, and what the paper leaves out, as SVG and PNG."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from validation.markdown import spaced
from validation.paper.dispersion import Fit, in_turn
from validation.paper.edges import EDGES, GAIN, pairs
from validation.paper.growth import stability
from validation.paper.results import Results, Row, Time, by_radix, one, place, where

#: Colors of Okabe and Ito, which people with color-blindness tell apart, and a marker for each search.
METHODS = {
    "standard": ("#000000", "s"),
    "octant": ("#D55E00", "o"),
    "trimmed": ("#0072B2", "^"),
    "midplane": ("#009E73", "D"),
    "brute": ("#999999", "x"),
}

#: Line of an edge, in neighbor cutoffs R.
DASHES = {
    0.5: (0, (1, 3)),
    1.0: (0, (1, 1)),
    2.0: "-",
    2.52: (0, (5, 2)),
    4.0: (0, (5, 2, 1, 2)),
    math.inf: "-",
}

#: Color and marker of an edge where only one search is shown.
EDGE_LOOKS = {2.0: ("#D55E00", "o"), 2.52: ("#0072B2", "^"), 4.0: ("#009E73", "D")}

#: Searches on octants, as the panels of figure 5 call them.
OCTANTS = {"octant": "octant", "trimmed": "trimmed octant", "midplane": "octant, mid-plane"}

#: Directions of figure 4 that a line of its own shows, each from the own cell on.
DIRECTIONS = {"X": ("#D55E00", "o"), "Y": ("#0072B2", "s"), "Z": ("#009E73", "^")}


def write(results: Results) -> list[Path]:
    """Draws every figure into the folder of the results; the paths of what it wrote."""
    plt.rcParams.update(
        {"font.size": 9, "svg.hashsalt": "octant", "axes.spines.top": False, "axes.spines.right": False}
    )
    draw: dict[str, Callable[[Sequence[Row]], Figure]] = {
        "stability": stability,
        "figure4": figure_4,
        "orders": orders,
        "figure5": figure_5,
        "distributions": distributions,
    }
    written = []
    for name, drawn in draw.items():
        figure = drawn(results.tables[name])
        for path, options in (
            (results.folder / f"{name}.png", {"dpi": 150}),
            (results.folder / f"{name}.svg", {"metadata": {"Date": None}}),
        ):
            figure.savefig(path, **options)
            written.append(path)
        plt.close(figure)
    return written


def _sizes(panel: Axes, rows: Sequence[Row]) -> None:
    """An axis of numbers of particles, with marks at those that were measured: 1k, 200k, 10M."""
    sizes = sorted({int(row["particles"]) for row in rows})
    panel.set_xscale("log")
    panel.set_xticks(sizes, [f"{n / 1e6:g}M" if n >= 1e6 else f"{n / 1e3:g}k" for n in sizes])
    panel.xaxis.set_minor_locator(NullLocator())
    panel.tick_params(axis="x", labelrotation=45)
    panel.set_xlabel("particles")


def orders(rows: Sequence[Row]) -> Figure:
    """Sort and list beside those with rows of cells and counting, by size: a Z-order curve, and a radix sort."""
    figure, panels = plt.subplots(1, 3, figsize=(12, 4.2), layout="constrained", sharey=True)
    methods = list(dict.fromkeys((row["method"], float(row["edge"])) for row in rows))
    drawn = (
        ("list along a Z-order curve, over rows", {"order": "zorder", "sort": "counting"}, "list_us"),
        ("sort along a Z-order curve, over rows", {"order": "zorder", "sort": "counting"}, "sort_us"),
        ("radix sort, over counting", {"sort": "radix"}, "sort_us"),
    )
    for panel, (title, wanted, column) in zip(panels, drawn, strict=True):
        for method, edge in methods:
            color, marker = METHODS[method]
            of = where(rows, method=method, edge=edge)
            if wanted == {"sort": "radix"}:
                pairs = by_radix(of)
            else:
                base = {"order": "rows", "sort": "counting"}
                pairs = [(row, one(of, particles=int(row["particles"]), **base)) for row in where(of, **wanted)]
            points = [(int(row["particles"]), float(row[column]) / float(base[column])) for row, base in pairs]
            if points:
                look = {"color": color, "marker": marker, "ls": DASHES[edge], "ms": 4, "lw": 1.1}
                panel.plot(*zip(*sorted(points), strict=True), label=_name(method, edge), **look)
        measured = bool(panel.lines)
        panel.axhline(1, color="0.6", lw=0.8, zorder=0)
        panel.set_title(title, loc="left", fontsize=9)
        panel.grid(color="0.92", lw=0.6)
        if measured:
            _sizes(panel, rows)
            panel.legend(frameon=False, fontsize=7)
        else:
            panel.set_xticks([])
            panel.text(0.5, 0.5, "not on this engine", transform=panel.transAxes, ha="center", color="0.5")
    panels[0].set_yscale("log")
    _plain(panels[0].yaxis, _RATIOS)
    panels[0].set_ylabel("ratio of times")
    figure.suptitle(f"Order of cells and sort: {place(rows)}", fontsize=9)
    return figure


def figure_4(rows: Sequence[Row]) -> Figure:
    """Time against adjacent cells: one direction alone on the left, X, Y and Z in turn with the fitted line on the right."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.4), layout="constrained")
    own = [row for row in rows if row["direction"] == "own"]
    for direction, (color, marker) in DIRECTIONS.items():
        line = own + [row for row in rows if row["direction"] == direction]
        _line(left, line, "adjacent_cells", "list_us", color=color, marker=marker, label=direction)
    left.set_title("one direction alone", loc="left")
    left.set_xticks([0, 1, 2])
    turn = in_turn(rows)
    _line(right, turn, "adjacent_cells", "list_us", color="#000000", marker="o", label="measured")
    fit, ends = Fit.through(turn), [float(row["adjacent_cells"]) for row in (turn[0], turn[-1])]
    label = f"fitted line, R² = {fit.squared:.3f}"
    right.plot(ends, [fit.at(end) for end in ends], color="#D55E00", lw=1, ls=(0, (5, 2)), label=label)
    # Beside the points they would lie on the line or beyond the axes.
    above = right.secondary_xaxis("top")
    above.set_xticks([float(row["adjacent_cells"]) for row in turn], [row["block"] for row in turn])
    above.tick_params(labelsize=7, labelrotation=90, color="0.6", labelcolor="0.4")
    above.spines["top"].set_visible(False)
    right.set_title("X, then Y, then Z (above: cells along each axis)", loc="left")
    for panel in (left, right):
        panel.set_xlabel(f"adjacent cells searched, {rows[0]['load']} particles each")
        panel.set_ylabel("µs a list, without the sort")
        panel.set_ylim(bottom=0)
        panel.grid(color="0.92", lw=0.6)
        panel.legend(frameon=False, loc="lower right")
    figure.suptitle(f"Figure 4: {spaced(int(rows[0]['particles']))} particles, {place(rows)}", fontsize=9)
    return figure


def figure_5(rows: Sequence[Row]) -> Figure:
    """Above what the paper compares, as times and as octant's gain, and standard's other edges; below the searches on octants."""
    figure, ((times, gains, others), below) = plt.subplots(2, 3, figsize=(14, 8.4), layout="constrained")
    for method in ("standard", "octant"):
        for edge in EDGES:
            color, marker = METHODS[method]
            look = {"color": color, "marker": marker, "ls": DASHES[edge], "label": _name(method, edge)}
            _line(times, where(rows, method=method, edge=edge), "particles", "build_us", **look)
    times.set_yscale("log")
    times.set_ylabel("µs a build, sort included")
    times.set_title("the paper's searches and edges", loc="left")
    _gains(gains, rows)
    wide = [*(("standard", edge) for edge in (0.5, *EDGES)), ("brute", math.inf)]
    shown = [(others, "standard, other edges; all pairs", wide)]
    for panel, (method, title) in zip(below, OCTANTS.items(), strict=True):
        shown.append((panel, title, [(method, edge) for edge in EDGES]))
    for panel, title, searches in shown:
        for method, edge in searches:
            color, marker = EDGE_LOOKS[edge] if method in OCTANTS else METHODS[method]
            look = {"color": color, "marker": marker, "ls": DASHES[edge], "label": _name(method, edge)}
            found = pairs(rows, (method, edge), ("standard", 1.0), "build_us")
            _bars(panel, {size: a.over(usual) for size, (a, usual) in found.items()}, **look)
        panel.axhline(1, color="0.5", lw=1, zorder=0, label=_name("standard", 1.0))
        panel.set_yscale("log")
        _plain(panel.yaxis, _RATIOS)
        panel.set_title(title, loc="left")
        panel.set_ylabel("time of a build over standard's with cells of R")
    # One scale, so that the searches can be compared; that with all pairs is far beyond it.
    limits = [limit for panel in below for limit in panel.get_ylim()]
    for panel in below:
        panel.set_ylim(min(limits), max(limits))
    for panel in (times, gains, others, *below):
        _sizes(panel, rows)
        panel.grid(color="0.92", lw=0.6)
        panel.legend(frameon=False, fontsize=7, handlelength=3.5)
    figure.suptitle(f"Figure 5: {place(rows)}", fontsize=9)
    return figure


def _gains(panel: Axes, rows: Sequence[Row]) -> None:
    """Octant over standard at equal edge, beside what the paper says it is."""
    panel.axhspan(*GAIN, color="0.85", zorder=0, label=f"the paper: {GAIN[0]:g} to {GAIN[1]:g} %")
    for column, what, filled in (("list_us", "list alone", True), ("build_us", "with the sort", False)):
        for edge in EDGES:
            color, marker = EDGE_LOOKS[edge]
            found = pairs(rows, ("standard", edge), ("octant", edge), column)
            percent = {
                size: Time(*(100 * (by - 1) for by in (over.median, over.least, over.most)))
                for size, over in ((size, standard.over(octant)) for size, (standard, octant) in found.items())
            }
            look = {"color": color, "marker": marker, "mfc": color if filled else "white", "ls": "-" if filled else ":"}
            _bars(panel, percent, label=f"{edge:g} R, {what}", **look)
    panel.axhline(0, color="0.6", lw=0.8, zorder=0)
    panel.set_ylabel("octant faster than standard by, %")
    panel.set_title("octant's gain at equal edge", loc="left")


def distributions(rows: Sequence[Row]) -> Figure:
    """Time for each neighbor found, by search: of the list, and in gray with the sort; a panel a distribution."""
    names = list(dict.fromkeys(row["distribution"] for row in rows))
    figure, panels = plt.subplots(
        1, len(names), figsize=(3.2 * len(names), 4.2), layout="constrained", sharex=True, sharey=True, squeeze=False
    )
    for panel, name in zip(panels[0], names, strict=True):
        shown = where(rows, distribution=name)
        for row in shown:
            color, marker = METHODS[row["method"]]
            times = [float(row[column]) for column in ("list_ns_per_neighbor", "build_ns_per_neighbor")]
            panel.plot(times, [row["search"]] * 2, color="0.7", lw=1.5, marker="|", zorder=1)
            panel.plot(times[:1], [row["search"]], color=color, marker=marker, ms=5)
        panel.set_xscale("log")
        _plain(panel.xaxis, (1, 2, 5))
        panel.tick_params(axis="x", labelsize=7, labelrotation=45)
        panel.grid(axis="x", color="0.92", lw=0.6)
        panel.set_title(f"{name}: {spaced(int(shown[0]['particles']))} particles", loc="left", fontsize=9)
        panel.set_xlabel("ns a neighbor found (gray: with the sort)")
    panels[0][0].invert_yaxis()
    figure.suptitle(f"List builds by distribution: {place(rows)}", fontsize=9)
    return figure


#: Marks of a logarithmic axis of ratios, in each power of ten.
_RATIOS = (1, 1.5, 2, 3, 5, 7)


def _plain(axis: Axis, marks: Sequence[float]) -> None:
    """Marks of a logarithmic axis at these times powers of ten, as plain numbers: powers of ten alone are too few."""
    axis.set_major_locator(LogLocator(subs=marks))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
    axis.set_minor_locator(NullLocator())


def _name(method: str, edge: float) -> str:
    return "all pairs" if math.isinf(edge) else f"{method}, {edge:g} R"


def _line(panel: Axes, rows: Sequence[Row], x: str, y: str, **look: object) -> None:
    """Medians of a column, with bars from least to most."""
    _bars(panel, {float(row[x]): Time.of(row, y) for row in rows}, **look)


def _bars(panel: Axes, points: dict[float, Time], **look: object) -> None:
    """Medians, with bars from least to most."""
    at = dict(sorted(points.items()))
    below = [time.median - time.least for time in at.values()]
    above = [time.most - time.median for time in at.values()]
    medians = [time.median for time in at.values()]
    panel.errorbar(list(at), medians, [below, above], ms=4, lw=1.1, elinewidth=0.8, **look)
