"""LAMMPS's side of the comparison, kept in a file: it comes back bit for bit, and it still notices what is wrong."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from validation.cases import all_cases, atoms_by_lammps, compare_case
from validation.compare import compare_scene
from validation.octant_runner import ROOT
from validation.reference import Reference, SceneReference, StaleReference, run_scene
from validation.scene import Scene, all_scenes

SCENE = next(scene for scene in all_scenes() if scene.name == "images")


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> SceneReference:
    return run_scene(SCENE, SCENE.quick, tmp_path_factory.mktemp("lammps"))


@pytest.fixture(scope="module", params=["reference.json", "reference.json.gz"])
def kept(request: pytest.FixtureRequest, fresh: SceneReference, tmp_path_factory: pytest.TempPathFactory) -> Reference:
    folder = tmp_path_factory.mktemp("kept")
    case = all_cases()[0]
    reference = Reference("1.2.3", True, {SCENE.name: fresh}, {case.name: atoms_by_lammps(case, folder)})
    reference.save(folder / request.param)
    return Reference.load(folder / request.param)


def test_every_bit_comes_back(fresh: SceneReference, kept: Reference) -> None:
    assert (kept.lammps, kept.quick) == ("1.2.3", True)
    scene = kept.scenes[SCENE.name]
    for item in dataclasses.fields(fresh):
        ours, theirs = getattr(scene, item.name), getattr(fresh, item.name)
        if item.name == "frames":
            assert [frame.columns for frame in ours] == [("id", "fx", "fy", "fz"), ("id", "x", "y", "z")]
            for one, other in zip(ours, theirs, strict=True):
                assert (one.values.tobytes(), one.step) == (other.values.tobytes(), other.step)
                assert np.array_equal(one.bounds, other.bounds) and np.array_equal(one.periodic, other.periodic)
        elif isinstance(theirs, np.ndarray):
            assert np.array_equal(ours, theirs) and ours.dtype == theirs.dtype
        else:
            assert ours == theirs, item.name


def test_octant_agrees_with_what_was_kept(kept: Reference, tmp_path: Path) -> None:
    result = compare_scene(SCENE, kept.scenes[SCENE.name], tmp_path / "scratch")
    assert [check.name for check in result.checks if not check.passed] == []
    assert {"forces, max", "neighbors when melted", "mixed: list length", "single: forces, RMS"} <= {
        check.name for check in result.checks
    }
    case = all_cases()[0]
    assert compare_case(case, kept.cases[case.name], tmp_path).passed


def test_precisions_are_chosen(kept: Reference, tmp_path: Path) -> None:
    names = [
        check.name for check in compare_scene(SCENE, kept.scenes["images"], tmp_path / "s", among=["mixed"]).checks
    ]
    assert any(name.startswith("mixed: ") for name in names)
    assert "forces, max" not in names and not any(name.startswith("single: ") for name in names)


def test_wrong_numbers_are_noticed(kept: Reference, tmp_path: Path) -> None:
    scene = kept.scenes[SCENE.name]
    first, last = scene.frames
    forces = first.values.copy()
    forces[3, 1] *= 1 + 1e-9
    counts = scene.melted_neighbors.copy()
    counts[5] += 1
    wrong = dataclasses.replace(
        scene, frames=[dataclasses.replace(first, values=forces), last], melted_neighbors=counts
    )
    result = compare_scene(SCENE, wrong, tmp_path / "scratch", among=["double"])
    assert {check.name for check in result.checks if not check.passed} >= {"forces, max", "neighbors when melted"}


def test_another_script_is_refused(kept: Reference, tmp_path: Path) -> None:
    changed = tmp_path / "images.in"
    changed.write_text(SCENE.path.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    with pytest.raises(StaleReference, match="images.in"):
        compare_scene(Scene(changed), kept.scenes[SCENE.name], tmp_path / "scratch")


def test_command_line_wants_a_file(tmp_path: Path) -> None:
    call = [sys.executable, "-m", "validation", "--reference", str(tmp_path / "none.json")]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "none.json" in done.stderr
