"""Files of ``octant paper`` that were cut off or name something twice: what is whole is judged, the rest is said."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from validation.octant_runner import ROOT, call
from validation.paper import claims, figures, page
from validation.paper.layout import LAYOUTS, Unfit
from validation.paper.results import NAMES, Results


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("paper")
    done = call("paper", "--quick", "--backend", "cpu", "--sizes", "500,1000", "--rounds", "1", "--out", folder)
    assert done.returncode == 0, done.stderr
    return folder


def changed(measured: Path, folder: Path, name: str, change: Callable[[list[str]], list[str]]) -> Path:
    """The same files but one, whose lines are others."""
    shutil.copytree(measured, folder, dirs_exist_ok=True)
    path = folder / f"{name}.csv"
    path.write_text("".join(change(path.read_text(encoding="utf-8").splitlines(keepends=True))), encoding="utf-8")
    return folder


def test_a_whole_run_is_whole(measured: Path) -> None:
    results = Results.read(measured)
    assert not results.cut and results.sizes == [500, 1000]
    for name in NAMES:
        lines = (measured / f"{name}.csv").read_text(encoding="utf-8").splitlines()
        assert len(results.tables[name]) == len(lines) - 1


@pytest.mark.parametrize("end", ["", "unif", "uniform,1000,standard:2,standard"])
def test_a_size_that_was_cut_off_is_left_out(measured: Path, tmp_path: Path, end: str) -> None:
    results = Results.read(changed(measured, tmp_path, "figure5", lambda lines: [*lines[:18], end]))
    assert results.sizes == [500]
    assert results.cut == ("`figure5.csv` was cut off: particles 1000 left out (2 of 17 rows).",)
    assert "| edge | 500 |" in "\n".join(claims.gain(results).lines)
    assert results.cut[0] in page.page([results], tmp_path)
    assert figures.write(results)


@pytest.mark.parametrize("name", NAMES)
def test_files_without_a_whole_part_are_told(measured: Path, tmp_path: Path, name: str) -> None:
    """However many rows a file has, a page is written or a sentence says what is missing."""
    rows = len((measured / f"{name}.csv").read_text(encoding="utf-8").splitlines())
    for kept in range(rows):
        folder = changed(measured, tmp_path, name, lambda lines, kept=kept: lines[:kept])
        try:
            results = Results.read(folder)
        except Unfit as error:
            assert str(error).startswith(f"{folder / name}.csv: ")
            assert "it was cut off: there is no row of" in str(error) or "there are no rows in it" in str(error)
        else:
            assert page.page([results], folder)


@pytest.mark.parametrize(
    ("name", "kept", "said"),
    [
        ("figure5", 4, "figure5.csv: it was cut off: there is no row of particles 500 search midplane and 7 others"),
        ("figure4", 3, "figure4.csv: it was cut off: there is no row of direction X, adjacent_cells 2 and 8 others"),
        ("figure4", 1, "figure4.csv: there are no rows in it"),
    ],
)
def test_a_file_that_was_cut_off_is_no_traceback(measured: Path, tmp_path: Path, name: str, kept: int, said: str) -> None:
    changed(measured, tmp_path, name, lambda lines: lines[:kept])
    words = [sys.executable, "-m", "validation.paper", tmp_path]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == f"{tmp_path}/{said}; `octant paper --out {tmp_path}` writes it anew\n"


@pytest.mark.parametrize("name", NAMES)
def test_a_row_that_is_there_twice_is_told(measured: Path, tmp_path: Path, name: str) -> None:
    changed(measured, tmp_path, name, lambda lines: [*lines, lines[1]])
    with pytest.raises(Unfit, match=rf"{name}\.csv: two rows are of .*; each is to be measured once"):
        Results.read(tmp_path)


def test_a_column_that_is_not_there_is_told(measured: Path, tmp_path: Path) -> None:
    for name, layout in LAYOUTS.items():
        column = (*layout.group, *layout.member)[0]
        changed(measured, tmp_path, name, lambda lines, column=column: [lines[0].replace(column, "else", 1), *lines[1:]])
        with pytest.raises(Unfit, match=f"there is no column '{column}' in it"):
            Results.read(tmp_path)
        shutil.copy(measured / f"{name}.csv", tmp_path)


def test_make_paper_runs_on_both_engines_and_makes_one_page() -> None:
    words = ["make", "--dry-run", "--silent", "--old-file=build", "paper", "PAPER_FLAGS=--quick --rounds 1"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    for backend in ("cpu", "cuda"):
        assert f"octant paper --backend {backend} --quick --rounds 1 --out output/paper/{backend}" in done.stdout
    assert "-m validation.paper $folders --page output/paper/paper.md" in done.stdout
