"""A selection of `make validate` that takes a minute or two: every scene, smaller and shorter, and every case."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from validation import report
from validation.cases import Case, all_cases, atoms_by_lammps, compare_case
from validation.compare import compare_scene
from validation.octant_runner import call, count_neighbors, run_octant
from validation.reference import run_scene
from validation.scene import INPUTS, Scene, all_scenes

SCENES = all_scenes()


@pytest.fixture(scope="module")
def results() -> dict:
    """What the scenes gave, for the report."""
    return {}


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_scene_equals_lammps(scene: Scene, tmp_path: Path, results: dict) -> None:
    # The benchmark's digits are promised at its full size.
    reference = run_scene(scene, {} if scene.every_digit else scene.quick, tmp_path)
    result = compare_scene(scene, reference, tmp_path / "scratch")
    results[scene.name] = result
    outside = [
        f"{check.name}: {check.value:.3g} > {check.bound:.3g} ({check.detail})"
        for check in result.checks
        if not check.passed
    ]
    assert outside == []


@pytest.mark.parametrize("case", all_cases(), ids=lambda case: case.name)
def test_case_equals_lammps_in_every_bit(case: Case, tmp_path: Path) -> None:
    check = compare_case(case, atoms_by_lammps(case, tmp_path), tmp_path)
    assert check.value == 0, check.detail


def test_report_is_written(results: dict, tmp_path: Path) -> None:
    if not results:
        pytest.skip("no scene was run")
    report.write(tmp_path, list(results.values()), [], report.about(lammps="1", backend="cpu", quick=True))
    data = json.loads((tmp_path / "validation.json").read_text())
    assert [scene["name"] for scene in data["scenes"]] == list(results)
    table = (tmp_path / "validation.md").read_text()
    assert all(f"| {name} |" in table for name in results)
    assert (tmp_path / "validation.png").stat().st_size > 10_000
    assert "<svg" in (tmp_path / "validation.svg").read_text()[:500]


@pytest.mark.parametrize("name", ["cluster", "mixture", "slab"])
def test_threads_give_the_same_bits(name: str, tmp_path: Path) -> None:
    scene = next(scene for scene in SCENES if scene.name == name)
    outcomes = []
    for threads in (1, 2, 5):
        out = tmp_path / str(threads)
        out.mkdir()
        result = run_octant(scene.path, {**scene.variables, **scene.quick, "out": str(out)}, threads=threads)
        trajectory = next(path for path in out.iterdir() if path.suffix in (".nc", ".xyz"))
        outcomes.append((result.summary["thermo"], result.summary["neighbors"], trajectory.read_bytes()))
    assert outcomes[0] == outcomes[1] == outcomes[2]


@pytest.mark.parametrize("name", ["dense", "images", "slab"])
def test_searches_find_the_same_neighbors(name: str, tmp_path: Path) -> None:
    scene = next(scene for scene in SCENES if scene.name == name)
    counts = [
        count_neighbors(scene.path, {**scene.variables, **scene.quick, "out": str(tmp_path)}, search=search)
        for search in ("trimmed", "octant", "octant:2.52", "midplane", "midplane:4", "standard", "standard:0.5", "brute")
    ]
    assert all(np.array_equal(count, counts[0]) for count in counts[1:])


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_check_runs_nothing(scene: Scene, tmp_path: Path) -> None:
    variables = [
        word for name, value in {**scene.variables, "out": str(tmp_path)}.items() for word in ("-v", f"{name}={value}")
    ]
    done = call("check", scene.path, *variables, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert list(tmp_path.iterdir()) == []


def test_main_scene_as_the_readme_runs_it(tmp_path: Path) -> None:
    done = call("run", INPUTS / "melt.in", "-v", "size=5", "-v", "steps=100", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "melt.nc").stat().st_size > 0
    assert (tmp_path / "log.octant").is_file()
    assert "melt.nc" in done.stdout + done.stderr
