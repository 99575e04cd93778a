"""The figure: speed against the number of atoms with all peers, force error and drift beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter

from validation.bench.figures import OTHER, STYLES
from validation.bench.gpu import tables
from validation.bench.gpu.plan import PLAIN
from validation.bench.gpu.tables import Group

#: Colors of Okabe and Ito and a marker each; programs measured in this run are drawn full, others dashed and hollow.
_OPENMM = {"single": ("#009E73", "P"), "mixed": ("#56B4E9", "X")}
_PEERS = {
    ("LAMMPS-KOKKOS", "double"): ("#000000", "^"),
    ("HOOMD", "double"): ("#7F7F7F", "<"),
    ("HOOMD", "single"): ("#7F7F7F", ">"),
    ("OpenMM", "single"): _OPENMM["single"],
    ("OpenMM", "mixed"): _OPENMM["mixed"],
    ("RUMD", ""): ("#E69F00", "D"),
    ("HALMD", ""): ("#CC79A7", "h"),
}

_DASHES = (0, (4, 3))


def write(folder: Path) -> None:
    """Writes ``speed.svg`` and ``speed.png`` beside the tables."""
    own = tables.groups(tables.read(folder / tables.BENCH), scene=PLAIN)
    openmm, peers = tables.groups(tables.read(folder / tables.OPENMM)), tables.read(tables.PEERS)
    plt.rcParams.update(
        {"font.size": 9, "svg.hashsalt": "octant", "axes.spines.top": False, "axes.spines.right": False}
    )
    figure = plt.figure(figsize=(12, 6.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.5, 1))
    speed = figure.add_subplot(grid[:, 0])
    error, drift = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    for panel in (speed, error, drift):
        panel.grid(color="0.92", lw=0.6)
        panel.set_axisbelow(True)
        panel.set_xscale("log")
        panel.xaxis.set_major_locator(LogLocator(numticks=12))
        panel.xaxis.set_minor_locator(NullLocator())
    _speed(speed, own, openmm, peers)
    _error(error, own, openmm)
    _drift(drift, own)
    low, high = speed.get_xlim()
    for panel in (error, drift):
        panel.set_xlim(low, high)
    figure.savefig(folder / "speed.png", dpi=150)
    figure.savefig(folder / "speed.svg", metadata={"Date": None})
    plt.close(figure)


def _by_precision(groups: Sequence[Group]) -> dict[str, list[Group]]:
    found: dict[str, list[Group]] = {}
    for group in groups:
        found.setdefault(group.precision, []).append(group)
    return found


def _look(program: str, precision: str) -> tuple[str, str]:
    if program == "OpenMM":
        return _OPENMM.get(precision, OTHER)
    return STYLES.get(f"octant {precision}", OTHER)


def _speed(panel: Axes, own: Sequence[Group], openmm: Sequence[Group], peers: Sequence[tables.Row]) -> None:
    panel.set_yscale("log")
    for program, groups in (("octant", own), ("OpenMM", openmm)):
        for precision, same in _by_precision(groups).items():
            color, marker = _look(program, precision)
            spans = [group.speed() for group in same]
            middle = [span.median for span in spans]
            bars = [[s.median - s.least for s in spans], [s.most - s.median for s in spans]]
            label = f"{program} {precision}, this run"
            panel.errorbar(
                [group.atoms for group in same],
                middle,
                bars,
                color=color,
                marker=marker,
                ms=6.5,
                lw=1.8,
                capsize=2,
                label=label,
                zorder=3,
            )
    for (program, precision), (color, marker) in _PEERS.items():
        same = [peer for peer in peers if (peer["program"], peer["precision"]) == (program, precision)]
        if not same:
            continue
        panel.plot(
            [int(peer["atoms"]) for peer in same],
            [float(peer["matom_steps_per_s"]) for peer in same],
            color=color,
            marker=marker,
            ms=6,
            mfc="white",
            mew=1.2,
            lw=1,
            ls=_DASHES,
            zorder=2,
            label=" ".join(filter(None, (program, precision))) + f", {_origin(same[0])}",
        )
    panel.set_title("Speed; dashed and hollow: measured separately", loc="left")
    panel.set_xlabel("atoms")
    panel.set_ylabel("million atom-steps a second")
    panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    panel.yaxis.set_major_formatter(ScalarFormatter())
    panel.yaxis.set_minor_locator(NullLocator())
    handles, labels = panel.get_legend_handles_labels()
    # Programs of this run first: lines with bars come last by themselves.
    order = sorted(range(len(labels)), key=lambda k: not labels[k].endswith("this run"))
    chosen = [handles[k] for k in order], [labels[k] for k in order]
    panel.figure.legend(*chosen, loc="outside lower center", ncols=3, frameon=False, fontsize=8.5)


def _origin(peer: tables.Row) -> str:
    """Where a peer's figures are from, for the legend."""
    dated = peer["date"][:1].isdigit()
    card = "" if "H100" in peer["hardware"] else f", {peer['hardware'].removeprefix('NVIDIA ')}"
    return (f"measured separately, {peer['date']}" if dated else peer["date"]) + card


def _error(panel: Axes, own: Sequence[Group], openmm: Sequence[Group]) -> None:
    panel.set_yscale("log")
    for program, groups in (("octant", own), ("OpenMM", openmm)):
        for precision, same in _by_precision(groups).items():
            color, marker = _look(program, precision)
            atoms = [group.atoms for group in same]
            for column, dashes, face in (("force_error_rms", "-", color), ("force_error_worst", ":", "white")):
                values = [group.most(column) for group in same]
                panel.plot(atoms, values, color=color, marker=marker, ms=5, mfc=face, lw=1.2, ls=dashes)
    panel.set_title("Force error", loc="left")
    panel.set_title("over the RMS force; full: RMS, hollow: worst atom", loc="right", color="0.4", fontsize=8)
    panel.yaxis.set_major_locator(LogLocator(numticks=8))
    panel.yaxis.set_minor_locator(NullLocator())


def _drift(panel: Axes, own: Sequence[Group]) -> None:
    panel.axhline(0, color="0.6", lw=0.8)
    for k, (precision, same) in enumerate(_by_precision(own).items()):
        color, marker = _look("octant", precision)
        found = [(group.atoms * 1.06**k, *drift) for group in same if (drift := group.drift())]
        if found:
            atoms, slopes, errors = zip(*found, strict=True)
            panel.errorbar(atoms, slopes, errors, color=color, marker=marker, ms=5, ls="none", capsize=2)
    panel.set_title("Drift of the energy", loc="left")
    panel.set_title("epsilon per atom and tau, standard error", loc="right", color="0.4", fontsize=8)
    panel.set_xlabel("atoms")
    panel.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2), useMathText=True)
