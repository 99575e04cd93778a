"""Growth of the energy against the timestep, drawn."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.markers import CARETDOWNBASE
from matplotlib.ticker import NullLocator

from validation.paper.results import Row, Time, place, where

#: Look of an integrator.
INTEGRATORS = {"nve/euler2": ("#D55E00", "o", "second-order Euler"), "nve": ("#0072B2", "s", "velocity Verlet")}

#: How the legend calls rates that are not told from none, and those of an energy that falls.
AT_MOST, FALLS = "at most", "the energy falls"


def stability(rows: Sequence[Row]) -> Figure:
    """Change of the energy a step against the timestep: a pair with its theory, then the particles of either force."""
    figure, panels = plt.subplots(1, 3, figsize=(12, 4.6), layout="constrained", sharey=True)
    pair, gas = where(rows, system="pair"), where(rows, system="gas")
    known = sorted((float(row["omega_dt"]), float(row["expected"])) for row in where(pair, integrator="nve/euler2"))
    panels[0].plot(*zip(*known, strict=True), color="0.6", lw=1, label="ln(1 + (ω dt)²/2)")
    for integrator, (color, marker, name) in INTEGRATORS.items():
        look = {"color": color, "marker": marker, "mfc": color, "ls": "none"}
        _rates(panels[0], where(pair, integrator=integrator), name, look)
    panels[0].set_title("a pair on springs", loc="left")
    panels[0].set_xlabel("ω dt (bars: uncertainty)")
    for panel, (force, title) in zip(panels[1:], (("spring", "F = k (R - r)"), ("inverse", "F = k / r")), strict=True):
        for box, dashes, fill in (("periodic", "-", None), ("walls", ":", "none")):
            for integrator, (color, marker, name) in INTEGRATORS.items():
                line = where(gas, force=force, box=box, integrator=integrator)
                look = {"color": color, "marker": marker, "mfc": fill or color, "ls": dashes}
                _rates(panel, line, f"{name}, {box}", look)
        panel.set_title(f"{gas[0]['particles']} particles, {title}", loc="left")
        panel.set_xlabel("sqrt(k/m) dt, the largest being the paper's (bars: seeds)")
    for panel, shown in zip(panels, (pair, gas, gas), strict=True):
        panel.set_xscale("log")
        panel.set_yscale("log")
        places = sorted({float(row["omega_dt"]) for row in shown})
        panel.set_xticks(places, [f"{at:.2g}" for at in places])
        panel.xaxis.set_minor_locator(NullLocator())
        panel.grid(color="0.92", lw=0.6)
        # Each word once, though several lines have such points.
        handles = dict(zip(*reversed(panel.get_legend_handles_labels()), strict=True))
        panel.legend(handles.values(), handles.keys(), frameon=False, fontsize=7, loc="lower right")
    panels[0].set_ylabel("|d ln E / d n|, relative change of the energy a step")
    figure.suptitle(f"The paper's step: {place(rows)}", fontsize=9)
    return figure


def rate(row: Row) -> Time:
    """Growth of a row, with the least and the most that it may be: by its uncertainty where that is known, else by the seeds."""
    if row["uncertainty"]:
        median, by = float(row["rate"]), float(row["uncertainty"])
        return Time(median, median - by, median + by)
    return Time.of(row, "rate")


def _rates(panel: Axes, rows: Sequence[Row], name: str, look: dict[str, object]) -> None:
    """Growth against the timestep, where some run lasted long enough to tell. What may be none at all is an upper limit."""
    rates = sorted((float(row["omega_dt"]), rate(row)) for row in rows if row["rate"])
    told = [(x, y) for x, y in rates if y.least * y.most > 0]
    sizes = [sorted((abs(y.least), abs(y.most))) for _, y in told]
    at = [abs(y.median) for _, y in told]
    bars = [[a - low for a, (low, _) in zip(at, sizes, strict=True)]]
    bars += [[most - a for a, (_, most) in zip(at, sizes, strict=True)]]
    if told:
        panel.errorbar([x for x, _ in told], at, bars, ms=4, lw=1.1, elinewidth=0.8, label=name, **look)
    if limits := [(x, max(abs(y.least), abs(y.most))) for x, y in rates if y.least * y.most <= 0]:
        label = f"{name}: {AT_MOST}"
        panel.plot(*zip(*limits, strict=True), ls="none", marker=CARETDOWNBASE, ms=8, color=look["color"], label=label)
    if falls := [(x, abs(y.median)) for x, y in told if y.median < 0]:
        panel.plot(*zip(*falls, strict=True), "o", ms=9, mfc="none", mec="0.4", mew=0.8, label=FALLS)
