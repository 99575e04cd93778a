"""Figures of ``octant paper``: they show every row that they should, and say what is missing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from validation.octant_runner import ROOT, call
from validation.paper import figures
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
    (line,) = right.get_lines()
    assert list(line.get_xdata()) == [0, 1, 2, 5, 8, 17, 26]
    times = {float(row["adjacent_cells"]): float(row["list_us"]) for row in rows if row["direction"] in ("own", "XYZ")}
    assert all(y == times[x] for x, y in zip(*line.get_data(), strict=True) if x in times)


def test_figure_5_has_every_search_and_size(measured: Results) -> None:
    rows = measured.tables["figure5"]
    panels = figures.figure_5(rows).axes
    shown = {bar.get_label() for panel in panels for bar in panel.containers}
    measured_as = {f"{row['method']}, {float(row['edge']):g} R" for row in rows if row["method"] != "brute"} | {
        "all pairs"
    }
    # Cells of 2R have no particles for which the mid-plane search spares one.
    assert shown == measured_as - {"midplane, 2 R"}
    for panel in panels:
        for line in panel.get_lines():
            assert list(line.get_xdata()) == [500, 1000] and all(y > 0 for y in line.get_ydata())


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
    pair, *gases = figures.stability(rows).axes
    theory, euler, verlet = pair.get_lines()
    assert list(theory.get_xdata()) == list(euler.get_xdata()) == list(verlet.get_xdata())
    assert list(theory.get_ydata()) == pytest.approx(list(euler.get_ydata()), abs=0.05)
    for panel, force in zip(gases, ("spring", "inverse"), strict=True):
        points = sum(len(line.get_xdata()) for line in panel.get_lines())
        assert points == sum(bool(row["rate"]) for row in where(rows, system="gas", force=force)) > 8


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
    assert (
        done.stderr == f"{tmp_path}/{NAMES[0]}.csv: there is no such file; `octant paper --out {tmp_path}` writes it\n"
    )
