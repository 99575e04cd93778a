"""Figures of ``octant paper``: they show every row that they should, and say what is missing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from validation.octant_runner import ROOT, call
from validation.paper import figures


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("paper")
    done = call("paper", "--quick", "--backend", "cpu", "--sizes", "500,1000", "--rounds", "1", "--out", folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_all_figures_are_drawn(measured: Path) -> None:
    written = figures.write(measured)
    names = {f"{name}.{kind}" for name in ("figure4", "figure5", "distributions") for kind in ("png", "svg")}
    assert {path.name for path in written} == names
    assert all(path.stat().st_size > 10_000 for path in written)


def test_figure_4_has_every_block(measured: Path) -> None:
    rows = figures.read(measured / "figure4.csv")
    left, right = figures.figure_4(rows).axes
    # From the own cell on, one and two more in a direction; in turn up to all 26.
    for line in left.get_lines():
        assert list(line.get_xdata()) == [0, 1, 2]
    assert [line.get_label() for line in left.containers] == ["X", "Y", "Z"]
    (line,) = right.get_lines()
    assert list(line.get_xdata()) == [0, 1, 2, 5, 8, 17, 26]
    times = {float(row["adjacent_cells"]): float(row["list_us"]) for row in rows if row["direction"] in ("own", "XYZ")}
    assert all(y == times[x] for x, y in zip(*line.get_data(), strict=True) if x in times)


def test_figure_5_has_every_search_and_size(measured: Path) -> None:
    rows = figures.read(measured / "figure5.csv")
    panels = figures.figure_5(rows).axes
    shown = {bar.get_label() for panel in panels for bar in panel.containers}
    measured_as = {f"{row['method']}, {float(row['edge']):g} R" for row in rows}
    # Cells of 2R have no particles for which the mid-plane search spares one.
    assert shown == measured_as - {"midplane, 2 R"}
    for panel in panels:
        for line in panel.get_lines():
            assert list(line.get_xdata()) == [500, 1000] and all(y > 0 for y in line.get_ydata())


def test_distributions_have_every_search(measured: Path) -> None:
    rows = figures.read(measured / "distributions.csv")
    panels = figures.distributions(rows).axes
    assert [panel.get_title(loc="left").split(":")[0] for panel in panels] == ["uniform", "liquid", "clustered", "dense"]
    searches = len({row["search"] for row in rows})
    for panel in panels:
        search, sort = panel.containers
        name = panel.get_title(loc="left").split(":")[0]
        builds = [float(row["build_ns_per_neighbor"]) for row in rows if row["distribution"] == name]
        assert len(search) == len(sort) == searches
        ends = [bar.get_width() + more.get_width() for bar, more in zip(search, sort, strict=True)]
        assert ends == pytest.approx(builds)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "validation.paper", tmp_path], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr == f"{tmp_path}/figure4.csv: there is no such file; `octant paper --out {tmp_path}` writes it\n"
