"""Figures of ``octant paper``: they show every row that they should, and say what is missing."""

from __future__ import annotations

import copy
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from validation.octant_runner import ROOT, call
from validation.paper import figures, growth
from validation.paper.results import NAMES, Results, where

#: Tables that have a figure.
DRAWN = ("stability", "figure4", "orders", "figure5", "distributions")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Results:
    folder = tmp_path_factory.mktemp("paper")
    done = call("paper", "--quick", "--backend", "cpu", "--sizes", "500,1000", "--rounds", "1", "--out", folder)
    assert done.returncode == 0, done.stderr
    return Results.read(folder)


def test_all_figures_are_drawn(measured: Results) -> None:
    written = figures.write(measured)
    names = {f"{name}.{kind}" for name in DRAWN for kind in ("png", "svg")}
    assert {path.name for path in written} == names
    assert all(path.stat().st_size > 10_000 for path in written)


def test_figure_4_has_every_block(measured: Results) -> None:
    rows = measured.tables["figure4"]
    left, right = figures.figure_4(rows).axes
    # From the own cell on, one and two more in a direction; in turn up to all 26.
    for line in left.get_lines():
        assert list(line.get_xdata()) == [0, 1, 2]
    assert [line.get_label() for line in left.containers] == ["X", "Y", "Z"]
    line, fitted = right.get_lines()
    assert list(line.get_xdata()) == [0, 1, 2, 5, 8, 17, 26] and list(fitted.get_xdata()) == [0, 26]
    x, y = (np.array(of, dtype=float) for of in line.get_data())
    slope, begin = np.polyfit(x, y, 1)
    assert list(fitted.get_ydata()) == pytest.approx([begin, begin + 26 * slope])
    assert fitted.get_label() == f"fitted line, R² = {np.corrcoef(x, y)[0, 1] ** 2:.3f}"
    times = {float(row["adjacent_cells"]): float(row["list_us"]) for row in rows if row["direction"] in ("own", "XYZ")}
    assert all(y == times[x] for x, y in zip(*line.get_data(), strict=True) if x in times)


def test_figure_5_has_every_search_and_size(measured: Results) -> None:
    rows = measured.tables["figure5"]
    times, gains, *ratios = figures.figure_5(rows).axes
    shown = [bar.get_label() for panel in ratios for bar in panel.containers]
    measured_as = {f"{row['method']}, {float(row['edge']):g} R" for row in rows if row["method"] != "brute"} | {
        "all pairs"
    }
    # What the others are measured by is the line of 1.
    assert sorted([*shown, "standard, 1 R"]) == sorted(measured_as)
    for panel in (times, *ratios):
        for bar in panel.containers:
            assert list(bar[0].get_xdata()) == [500, 1000] and all(y > 0 for y in bar[0].get_ydata())
    for panel in ratios:
        (one,) = (line for line in panel.get_lines() if line.get_label() == "standard, 1 R")
        assert set(one.get_ydata()) == {1}
        for bar in panel.containers:
            method, edge = ("brute", math.inf) if bar.get_label() == "all pairs" else bar.get_label()[:-2].split(", ")
            for x, y in zip(*bar[0].get_data(), strict=True):
                row, usual = (
                    where(rows, method=m, edge=float(e), particles=x)[0] for m, e in ((method, edge), ("standard", 1))
                )
                assert y == pytest.approx(float(row["build_us"]) / float(usual["build_us"]))


def test_figure_5_shows_the_gain_beside_what_the_paper_says(measured: Results) -> None:
    rows = measured.tables["figure5"]
    gains = figures.figure_5(rows).axes[1]
    (band,) = gains.patches
    assert (band.get_y(), band.get_y() + band.get_height()) == (85, 115) and "85 to 115 %" in band.get_label()
    shown = {bar.get_label(): list(bar[0].get_ydata()) for bar in gains.containers}
    assert len(shown) == 6
    times = {row["search"]: float(row["list_us"]) for row in where(rows, particles=500)}
    assert shown["2 R, list alone"][0] == pytest.approx(100 * (times["standard:2"] / times["octant"] - 1))


def test_distributions_have_every_search(measured: Results) -> None:
    rows = measured.tables["distributions"]
    panels = figures.distributions(rows).axes
    assert [panel.get_title(loc="left").split(":")[0] for panel in panels] == [
        "uniform",
        "liquid",
        "clustered",
        "dense",
    ]
    for panel in panels:
        shown = where(rows, distribution=panel.get_title(loc="left").split(":")[0])
        # Two lines a search: from the list to the whole build, and the list's mark.
        lines = panel.get_lines()
        assert len(lines) == 2 * len(shown)
        for row, whole, mark in zip(shown, lines[::2], lines[1::2], strict=True):
            times = [float(row[f"{part}_ns_per_neighbor"]) for part in ("list", "build")]
            assert list(whole.get_xdata()) == times and list(mark.get_xdata()) == times[:1]
            assert set(whole.get_ydata()) == set(mark.get_ydata()) == {row["search"]}


def test_stability_has_every_run(measured: Results) -> None:
    rows = measured.tables["stability"]
    pair, *gases = growth.stability(rows).axes
    theory, euler, verlet = pair.get_lines()
    assert list(theory.get_xdata()) == list(euler.get_xdata()) == list(verlet.get_xdata())
    assert list(theory.get_ydata()) == pytest.approx(list(euler.get_ydata()), abs=0.05)
    # What velocity Verlet's growth may be at most: nothing is seen of it.
    assert verlet.get_label() == "velocity Verlet: at most"
    limits = {float(row["omega_dt"]): growth.rate(row) for row in where(rows, system="pair", integrator="nve")}
    for x, y in zip(*verlet.get_data(), strict=True):
        assert y == max(-limits[x].least, limits[x].most) >= abs(limits[x].median)
    for panel, force in zip(gases, ("spring", "inverse"), strict=True):
        lines = [line for line in panel.get_lines() if line.get_label() != growth.FALLS]
        points = sum(len(line.get_xdata()) for line in lines)
        assert points == sum(bool(row["rate"]) for row in where(rows, system="gas", force=force)) > 8


def test_an_energy_that_falls_is_marked(measured: Results) -> None:
    rows = copy.deepcopy(measured.tables["stability"])
    for row in where(rows, system="gas", force="spring", integrator="nve", box="periodic"):
        row.update(rate="-2e-5", rate_least="-3e-5", rate_most="-1e-5")
    _, spring, _ = growth.stability(rows).axes
    (falls,) = (line for line in spring.get_lines() if line.get_label() == growth.FALLS)
    assert set(falls.get_ydata()) == {2e-5}
    # Seeds of which some rise and some fall tell no rate, only how large it may be.
    for row in where(rows, system="gas", force="spring", integrator="nve", box="periodic"):
        row.update(rate_most="4e-5")
    _, spring, _ = growth.stability(rows).axes
    (limits,) = (line for line in spring.get_lines() if growth.AT_MOST in str(line.get_label()))
    assert set(limits.get_ydata()) == {4e-5}
    assert growth.FALLS not in [line.get_label() for line in spring.get_lines()]


def test_orders_are_ratios(measured: Results) -> None:
    panels = figures.orders(measured.tables["orders"]).axes
    for panel in panels:
        # Four searches of two sizes, and the line of 1.
        assert [len(line.get_xdata()) for line in panel.get_lines()] == [2, 2, 2, 2, 2]
    radix = {line.get_label(): list(line.get_ydata()) for line in panels[2].get_lines()}
    rows = where(measured.tables["orders"], particles=500, order="rows")
    times = {row["sort"]: float(row["sort_us"]) for row in where(rows, method="octant")}
    assert radix["octant, 2 R"][0] == pytest.approx(times["radix"] / times["counting"])


def test_orders_without_a_radix_sort_are_drawn(measured: Results) -> None:
    *panels, radix = figures.orders(where(measured.tables["orders"], sort="counting")).axes
    assert [text.get_text() for text in radix.texts] == ["not on this engine"]
    assert all(len(panel.get_lines()) == 5 for panel in panels)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "validation.paper", tmp_path], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr.startswith(
        f"{tmp_path}/{NAMES[0]}.csv: there is no such file; `octant paper --out {tmp_path}` writes it"
    )
