"""The figure: cost against force error, and cost against the number of atoms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter, NullLocator, ScalarFormatter

from validation.bench.labels import place_labels
from validation.bench.plan import ASKED_LINEAR
from validation.bench.rows import COST, Row, Rows
from validation.bench.sections import ratios, sizes
from validation.markdown import cores, spaced

#: Colors of Okabe and Ito, which people with color-blindness tell apart, and a marker each.
STYLES = {
    "octant double": ("#0072B2", "s"),
    "octant mixed": ("#D55E00", "o"),
    "octant single": ("#CC79A7", "D"),
    "LAMMPS opt": ("#000000", "^"),
    "LAMMPS omp": ("#000000", "v"),
    "LAMMPS mpi": ("#000000", "<"),
    "OpenMM CPU": ("#009E73", "P"),
}
OTHER = ("#7F7F7F", "X")

#: An error of zero has no place on a logarithmic axis: it and smaller ones are drawn here.
_ZERO = 1e-17


def write(folder: Path, rows: Rows) -> None:
    """Writes ``bench.png`` and ``bench.svg``."""
    plt.rcParams.update(
        {"font.size": 9, "svg.hashsalt": "octant", "axes.spines.top": False, "axes.spines.right": False}
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5.2), layout="constrained", width_ratios=(1.25, 1))
    for panel in (left, right):
        panel.grid(color="0.92", lw=0.6)
        panel.set_axisbelow(True)
    _by_error(left, rows.where(section=ratios.NAME, value=COST))
    _by_size(right, rows.where(section=sizes.NAME, value=COST), sizes.compared_size(rows))
    figure.savefig(folder / "bench.png", dpi=150)
    figure.savefig(folder / "bench.svg", metadata={"Date": None})
    plt.close(figure)


def pareto(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points that no other is better than in one coordinate without being worse in the other; small is good."""
    front: list[tuple[float, float]] = []
    for x, y in sorted(points):
        if not front or y < front[-1][1]:
            front.append((x, y))
    return front


def _by_error(panel: Axes, costs: Rows) -> None:
    """One marker for each contestant: filled on one core, open on several."""
    points = [row for row in costs if not math.isnan(row.error_rms)]
    panel.set_title("Cost and force error", loc="left")
    if not points:
        _empty(panel, "not measured: needs the sections ratios and errors")
        return
    panel.set_xscale("log")
    panel.set_yscale("log")
    xs, ys = [_x(row) for row in points], [row.median for row in points]
    # Room for the labels on all sides.
    panel.set_xlim(min(xs) / 30, max(xs) * 100)
    panel.set_ylim(min(ys) / 1.6, max(ys) * 1.6)
    handles, fronts = [], []
    counts = sorted({row.threads for row in points})
    for threads in counts:
        same = [row for row in points if row.threads == threads]
        dashes = "-" if threads == 1 else (0, (4, 3))
        front = pareto([(_x(row), row.median) for row in same])
        # Along the front a better force costs more: its steps go where nothing is both faster and more exact.
        corners = [front[0]]
        for x, y in front[1:]:
            corners += [(x, corners[-1][1]), (x, y)]
        panel.plot(*zip(*corners, strict=True), color="0.6", lw=1.2, ls=dashes, zorder=1)
        fronts.append(corners)
        for row in same:
            color, marker = STYLES.get(row.contestant, OTHER)
            face = color if threads == 1 else "white"
            panel.plot(_x(row), row.median, marker, ms=7, mec=color, mfc=face, mew=1.4, ls="none", zorder=3)
        look = {"color": "0.6", "ls": dashes, "marker": "o", "mec": "0.3", "mfc": "0.3" if threads == 1 else "white"}
        handles.append(Line2D([], [], label=f"{cores(threads)}, with Pareto front", **look))
    panel.set_xlabel("force error, RMS over RMS force")
    panel.set_ylabel("ns per atom-step")
    panel.xaxis.set_major_locator(LogLocator(numticks=12))
    panel.xaxis.set_minor_formatter(NullFormatter())
    _plain_decades(panel)
    panel.set_title(f"{spaced(points[0].atoms)} atoms; lower left is better", loc="right", color="0.4", fontsize=8)
    panel.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=len(handles), frameon=False)
    panel.figure.canvas.draw()
    named = [(_x(row), row.median, row.contestant, STYLES.get(row.contestant, OTHER)[0]) for row in points]
    place_labels(panel, named, fronts)


def _x(row: Row) -> float:
    return max(row.error_rms, _ZERO)


def _by_size(panel: Axes, costs: Rows, main: int) -> None:
    """A line for each mode and number of cores, with the band that a linear cost stays in."""
    panel.set_title("Cost and size", loc="left")
    if not costs:
        _empty(panel, "not measured: needs the section sizes")
        return
    panel.set_xscale("log")
    panel.set_yscale("log")
    counts = sorted(costs.distinct("atoms"))
    low, high = counts[0] / 1.6, counts[-1] * 1.6
    for name in costs.distinct("contestant"):
        for threads in costs.where(contestant=name).distinct("threads"):
            line = sorted(costs.where(contestant=name, threads=threads), key=lambda row: row.atoms)
            color, marker = STYLES.get(name, OTHER)
            medians = [row.median for row in line]
            spans = [[row.median - row.q1 for row in line], [row.q3 - row.median for row in line]]
            look = {"marker": marker, "ms": 6, "mfc": color if threads == 1 else "white", "mew": 1.4, "lw": 1.2}
            dashes = "-" if threads == 1 else (0, (4, 3))
            label = f"{name}, {cores(threads)}"
            panel.errorbar(
                [row.atoms for row in line], medians, spans, color=color, ls=dashes, capsize=2, label=label, **look
            )
            middle = next((row.median for row in line if row.atoms == main), line[0].median)
            band = (middle * (1 - ASKED_LINEAR), middle * (1 + ASKED_LINEAR))
            panel.fill_between([low, high], *band, color=color, alpha=0.1, lw=0)
    panel.set_xlim(low, high)
    bottom, top = panel.get_ylim()
    panel.set_ylim(bottom / 1.15, top * 1.15)
    panel.set_xticks(counts, [spaced(count) for count in counts])
    panel.xaxis.set_minor_locator(NullLocator())
    _plain_decades(panel)
    panel.set_xlabel("atoms")
    panel.set_ylabel("ns per atom-step")
    band = f"bands: within {100 * ASKED_LINEAR:.0f} % of the cost at {spaced(main)} atoms"
    panel.set_title(band, loc="right", color="0.4", fontsize=8)
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False)


def _plain_decades(panel: Axes) -> None:
    """Ticks at 1, 2, 5 and their tens, written out."""
    panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    panel.yaxis.set_major_formatter(ScalarFormatter())
    panel.yaxis.set_minor_locator(NullLocator())


def _empty(panel: Axes, text: str) -> None:
    panel.text(0.5, 0.5, text, transform=panel.transAxes, ha="center", color="0.5")
    panel.set_xticks([])
    panel.set_yticks([])
