"""The plot of a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from validation import tolerances
from validation.compare import SceneResult

#: Colors of Okabe and Ito, which people with color-blindness tell apart, and a marker each.
_COLORS = ["#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000", "#8C8C00", "#7F7F7F", "#882255"]
_MARKERS = "osD^vPX<>*"

#: Panels: title, and the thermo columns it shows (the first a scene has).
_THERMO = [("Pair energy", ("E_pair", "PotEng")), ("Temperature", ("Temp",)), ("Pressure", ("Press",))]

#: A difference of zero has no place on a logarithmic axis: it and smaller ones are drawn at this value.
_ZERO = 1e-17


def _style(index: int) -> dict[str, str]:
    """How a scene is drawn: once all colors are used, with hollow markers on broken lines."""
    again, color = divmod(index, len(_COLORS))
    fill = "white" if again else _COLORS[color]
    line = "--" if again else "-"
    return {"color": _COLORS[color], "marker": _MARKERS[color], "markerfacecolor": fill, "linestyle": line}


def write(folder: Path, scenes: Sequence[SceneResult]) -> None:
    """Writes ``validation.png`` and ``.svg``: thermo differences over time, force and position differences by scene."""
    plt.rcParams.update(
        {"font.size": 9, "svg.hashsalt": "octant", "axes.spines.top": False, "axes.spines.right": False}
    )
    figure, axes = plt.subplots(1, 4, figsize=(14, 4.6), layout="constrained", sharey=True)
    end = max((point[0] for scene in scenes for column in scene.deviations.values() for point in column), default=1.0)
    times = np.linspace(0, end, 200)
    pairs = max((scene.pairs for scene in scenes), default=0)
    bounds = [tolerances.thermo_bound(time, pairs) for time in times]
    for panel, (title, names) in zip(axes, _THERMO, strict=False):
        panel.fill_between(times, bounds, 1, color="0.93", lw=0)
        panel.plot(times, bounds, color="0.45", lw=1)
        panel.set_title(title, loc="left")
        panel.set_xlabel("time / Lennard-Jones times")
        for index, scene in enumerate(scenes):
            name = next((name for name in names if name in scene.deviations), None)
            if name is None:
                continue
            time, difference = np.array(scene.deviations[name]).T
            panel.plot(time, np.maximum(difference, _ZERO), lw=0.8, ms=3.5, clip_on=False, label=scene.name, **_style(index))
    axes[0].text(
        0.04, 0.97, "outside tolerance (of the largest scene)", transform=axes[0].transAxes, va="top", color="0.4"
    )
    axes[0].set_ylabel("difference octant - LAMMPS, relative")

    panel = axes[-1]
    panel.set_title("Forces, and positions after 10 steps", loc="left")
    marks = [
        ("forces, max", "^", tolerances.FORCE_MAX),
        ("forces, RMS", "o", tolerances.FORCE_RMS),
        ("positions", "s", tolerances.POSITION),
    ]
    for offset, (name, marker, tolerance) in zip((-0.22, 0.0, 0.22), marks, strict=True):
        places = [index + offset for index, scene in enumerate(scenes) if scene.check(name)]
        values = [max(check.value, _ZERO) for scene in scenes if (check := scene.check(name))]
        color = _COLORS[marks.index((name, marker, tolerance))]
        panel.plot(places, values, marker, ms=5, clip_on=False, color=color, label=name)
        panel.hlines(tolerance.value, -0.5, len(scenes) - 0.5, color=color, lw=1, ls="--")
    panel.set_xticks(range(len(scenes)), [scene.name for scene in scenes], rotation=60, ha="right")
    panel.legend(loc="upper right", frameon=False)

    for panel in axes:
        panel.set_yscale("log")
        panel.set_ylim(_ZERO, 1e-3)
        panel.grid(axis="y", color="0.9", lw=0.6)
        panel.set_axisbelow(True)
    decades = range(-15, -2, 2)
    axes[0].set_yticks(
        [_ZERO, *(10.0**decade for decade in decades)], ["$\\leq 10^{-17}$", *(f"$10^{{{d}}}$" for d in decades)]
    )
    # As many as are as wide as the figure.
    ncols = min(len(scenes), 10)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=ncols, frameon=False)
    figure.savefig(folder / "validation.png", dpi=150)
    figure.savefig(folder / "validation.svg", metadata={"Date": None})
    plt.close(figure)
