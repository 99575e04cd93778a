"""Figures 4 and 5 of Morillo et al. 2015 as measured here, and what the paper leaves out, as SVG and PNG."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator

from validation.markdown import spaced
from validation.paper.results import Results, Row, one, place, where

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

#: Directions of figure 4 that a line of its own shows, each from the own cell on.
DIRECTIONS = {"X": ("#D55E00", "o"), "Y": ("#0072B2", "s"), "Z": ("#009E73", "^")}


#: Look of an integrator.
INTEGRATORS = {"nve/euler2": ("#D55E00", "o", "second-order Euler"), "nve": ("#0072B2", "s", "velocity Verlet")}


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


def stability(rows: Sequence[Row]) -> Figure:
    """Change of the energy a step against the timestep: a pair with its theory, then the particles of either force."""
    figure, panels = plt.subplots(1, 3, figsize=(12, 4.2), layout="constrained", sharey=True)
    pair = where(rows, system="pair")
    known = sorted((float(row["omega_dt"]), float(row["expected"])) for row in where(pair, integrator="nve/euler2"))
    panels[0].plot(*zip(*known, strict=True), color="0.6", lw=1, label="ln(1 + (ω dt)²/2)")
    for integrator, (color, marker, name) in INTEGRATORS.items():
        _rates(panels[0], where(pair, integrator=integrator), color=color, marker=marker, ls="none", label=name)
    panels[0].set_title("a pair on springs", loc="left")
    panels[0].set_xlabel("ω dt")
    gas = where(rows, system="gas")
    for panel, (force, title) in zip(panels[1:], (("spring", "F = k (R - r)"), ("inverse", "F = k / r")), strict=True):
        for box, dashes, fill in (("periodic", "-", None), ("walls", ":", "none")):
            for integrator, (color, marker, name) in INTEGRATORS.items():
                line = where(gas, force=force, box=box, integrator=integrator)
                look = {"color": color, "marker": marker, "ls": dashes, "label": f"{name}, {box}"}
                _rates(panel, line, mfc=fill or color, **look)
        panel.set_title(f"{gas[0]['particles']} particles, {title}", loc="left")
        panel.set_xlabel("sqrt(k/m) dt, the largest being the paper's")
    for panel, shown in zip(panels, (pair, gas, gas), strict=True):
        panel.set_xscale("log")
        panel.set_yscale("log")
        _ticks(panel, sorted({float(row["omega_dt"]) for row in shown}), "{:.2g}".format)
        panel.grid(color="0.92", lw=0.6)
        panel.legend(frameon=False, fontsize=7, loc="lower right" if shown is gas else "center right")
    panels[0].set_ylabel("|d ln E / d n|, relative change of the energy a step")
    figure.suptitle(f"The paper's step: {place(rows)}", fontsize=9)
    return figure


def _rates(panel: Axes, rows: Sequence[Row], **look: object) -> None:
    """Growth against the timestep, where some run lasted long enough to tell."""
    points = sorted((float(row["omega_dt"]), abs(float(row["rate"]))) for row in rows if row["rate"])
    panel.plot([x for x, _ in points], [y for _, y in points], ms=4, lw=1.1, **look)


def _ticks(panel: Axes, places: Sequence[float], label: Callable[[float], str]) -> None:
    """Marks of an axis of numbers that are what was measured at."""
    panel.set_xticks(places, [label(at) for at in places])
    panel.xaxis.set_minor_locator(NullLocator())


def _count(particles: float) -> str:
    """1k, 200k, 10M."""
    return f"{particles / 1e6:g}M" if particles >= 1e6 else f"{particles / 1e3:g}k"


def orders(rows: Sequence[Row]) -> Figure:
    """Sort and list beside those with rows of cells and counting, by size: a Z-order curve, and a radix sort."""
    figure, panels = plt.subplots(1, 3, figsize=(12, 4.2), layout="constrained", sharey=True)
    methods = list(dict.fromkeys((row["method"], float(row["edge"])) for row in rows))
    drawn = (
        ("list along a Z-order curve, over rows", {"order": "zorder", "sort": "counting"}, "list_us"),
        ("sort along a Z-order curve, over rows", {"order": "zorder", "sort": "counting"}, "sort_us"),
        ("radix sort, over counting", {"order": "rows", "sort": "radix"}, "sort_us"),
    )
    for panel, (title, wanted, column) in zip(panels, drawn, strict=True):
        for method, edge in methods:
            color, marker = METHODS[method]
            of = where(rows, method=method, edge=edge)
            points = []
            for row in where(of, **wanted):
                base = one(of, order="rows", sort="counting", particles=int(row["particles"]))
                points.append((int(row["particles"]), float(row[column]) / float(base[column])))
            if points:
                look = {"color": color, "marker": marker, "ls": DASHES[edge], "ms": 4, "lw": 1.1}
                panel.plot(*zip(*sorted(points), strict=True), label=_name(method, edge), **look)
        measured = bool(panel.lines)
        panel.axhline(1, color="0.6", lw=0.8, zorder=0)
        panel.set_title(title, loc="left", fontsize=9)
        panel.grid(color="0.92", lw=0.6)
        panel.set_xlabel("particles")
        if measured:
            panel.set_xscale("log")
            _ticks(panel, sorted({int(row["particles"]) for row in rows}), _count)
            panel.tick_params(axis="x", labelrotation=45)
            panel.legend(frameon=False, fontsize=7)
        else:
            panel.set_xticks([])
            panel.text(0.5, 0.5, "not on this engine", transform=panel.transAxes, ha="center", color="0.5")
    panels[0].set_ylim(bottom=0)
    panels[0].set_ylabel("ratio of times")
    figure.suptitle(f"Order of cells and sort: {place(rows)}", fontsize=9)
    return figure


def figure_4(rows: Sequence[Row]) -> Figure:
    """Time against adjacent cells: one direction alone on the left, X, Y and Z in turn on the right."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    own = [row for row in rows if row["direction"] == "own"]
    for direction, (color, marker) in DIRECTIONS.items():
        line = own + [row for row in rows if row["direction"] == direction]
        _line(left, line, "adjacent_cells", "list_us", color=color, marker=marker, label=direction)
    left.set_title("one direction alone", loc="left")
    left.legend(frameon=False, loc="lower right")
    left.set_xticks([0, 1, 2])
    in_turn = own + [row for row in rows if row["direction"] in ("X", "XY", "XYZ")]
    _line(right, in_turn, "adjacent_cells", "list_us", color="#000000", marker="o")
    # The first three are too near to each other to be named.
    for row in in_turn[2:]:
        at = (float(row["adjacent_cells"]), float(row["list_us"]))
        right.annotate(row["block"], at, textcoords="offset points", xytext=(4, -10), fontsize=7, color="0.4")
    right.set_title("X, then Y, then Z", loc="left")
    for panel in (left, right):
        panel.set_xlabel(f"adjacent cells with {rows[0]['load']} particles each")
        panel.set_ylabel("µs a list, without the sort")
        panel.set_ylim(bottom=0)
        panel.grid(color="0.92", lw=0.6)
    figure.suptitle(f"Figure 4: {rows[0]['particles']} particles, {place(rows)}", fontsize=9)
    return figure


def figure_5(rows: Sequence[Row]) -> Figure:
    """Time against the number of particles: what the paper compares on the left, all on the right."""
    figure, panels = plt.subplots(1, 2, figsize=(12, 5), layout="constrained", sharey=True)
    published = {"standard": (2.0, 2.52, 4.0), "octant": (2.0, 2.52, 4.0)}
    usual = {
        "standard": (0.5, 1.0, 2.0),
        "octant": (2.0,),
        "trimmed": (2.0, 2.52, 4.0),
        "midplane": (2.52, 4.0),
        "brute": (math.inf,),
    }
    titles = ("the paper's searches and edges", "beside what it leaves out")
    for panel, chosen, title in zip(panels, (published, usual), titles, strict=True):
        for method, edges in chosen.items():
            color, marker = METHODS[method]
            for edge in edges:
                line = [row for row in rows if row["method"] == method and float(row["edge"]) == edge]
                look = {"color": color, "marker": marker, "ls": DASHES[edge], "label": _name(method, edge)}
                _line(panel, line, "particles", "build_us", **look)
        panel.set_xscale("log")
        panel.set_yscale("log")
        _ticks(panel, sorted({int(row["particles"]) for row in rows}), _count)
        panel.set_xlabel("particles")
        panel.set_title(title, loc="left")
        panel.grid(color="0.92", lw=0.6)
        panel.legend(frameon=False, fontsize=7, handlelength=3.5)
    panels[0].set_ylabel("µs a build, sort included")
    figure.suptitle(f"Figure 5: {place(rows)}", fontsize=9)
    return figure


def distributions(rows: Sequence[Row]) -> Figure:
    """Time for each neighbor found, by search: of the list, and in gray with the sort; a panel a distribution."""
    names = list(dict.fromkeys(row["distribution"] for row in rows))
    figure, panels = plt.subplots(
        1, len(names), figsize=(3.2 * len(names), 4.2), layout="constrained", sharex=True, sharey=True
    )
    for panel, name in zip(panels, names, strict=True):
        shown = where(rows, distribution=name)
        for row in shown:
            color, marker = METHODS[row["method"]]
            times = [float(row[column]) for column in ("list_ns_per_neighbor", "build_ns_per_neighbor")]
            panel.plot(times, [row["search"]] * 2, color="0.7", lw=1.5, marker="|", zorder=1)
            panel.plot(times[:1], [row["search"]], color=color, marker=marker, ms=5)
        panel.set_xscale("log")
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.grid(axis="x", which="both", color="0.92", lw=0.6)
        panel.set_title(f"{name}: {spaced(int(shown[0]['particles']))} particles", loc="left", fontsize=9)
        panel.set_xlabel("ns a neighbor found (gray: with the sort)")
    panels[0].invert_yaxis()
    figure.suptitle(f"List builds by distribution: {place(rows)}", fontsize=9)
    return figure


def _name(method: str, edge: float) -> str:
    return "all pairs" if math.isinf(edge) else f"{method}, {edge:g} R"


def _line(panel: Axes, rows: Sequence[Row], x: str, y: str, **look: object) -> None:
    """Medians, with bars from least to most."""
    points = sorted(rows, key=lambda row: float(row[x]))
    medians = [float(row[y]) for row in points]
    below = [median - float(row[f"{y}_least"]) for row, median in zip(points, medians, strict=True)]
    above = [float(row[f"{y}_most"]) - median for row, median in zip(points, medians, strict=True)]
    xs = [float(row[x]) for row in points]
    panel.errorbar(xs, medians, [below, above], ms=4, lw=1.1, elinewidth=0.8, **look)
