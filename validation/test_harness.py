"""The comparison itself: it changes scripts as it says, and it notices what is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from validation.check import Check
from validation.compare import compare_counts
from validation.dumps import Frame, read_dump
from validation.lammps_runner import LammpsError, run_lammps
from validation.logs import read_log
from validation.octant_runner import OctantError, call, run_octant
from validation.scripts import Script

SCRIPT = Script.of("""
    units lj            # a comment
    region box block 0 1 &
      0 2 0 3
    create_box 2 box
    create_atoms 1 box
    mass * 1.0
    group heavy type 2
    pair_style lj/cut 2.5
    dump ours all chemfiles 10 a.nc
    dump theirs all xyz 10 a.xyz
    dump_modify ours first yes
    thermo 5
    run 10
    undump ours
    run 20
""")


def test_statements_are_joined_and_bare() -> None:
    assert SCRIPT.lines[:2] == ("units lj", "region box block 0 1        0 2 0 3")


def test_lammps_gets_its_own_dumps_only() -> None:
    dumps = [line for line in SCRIPT.for_lammps().lines if "dump" in line]
    assert dumps == ["dump theirs all xyz 10 a.xyz"]


def test_atoms_from_a_data_file() -> None:
    lines = SCRIPT.silent().from_data(Path("melted.data")).until_run().lines
    assert lines == ("units lj", "read_data melted.data", "group heavy type 2", "pair_style lj/cut 2.5")


def test_statements_before_every_run() -> None:
    lines = SCRIPT.before_runs("thermo_modify norm no").lines
    assert [lines[index - 1] for index, line in enumerate(lines) if line.startswith("run")] == [
        "thermo_modify norm no"
    ] * 2


def test_a_foreign_line_in_a_table_is_noticed(tmp_path: Path) -> None:
    log = tmp_path / "log"
    log.write_text("   Step Temp\n 0 1.5\nWARNING: something\nLoop time of 1\n", encoding="utf-8")
    with pytest.raises(ValueError, match="WARNING"):
        read_log(log)


def test_nan_and_missing_atoms_fail() -> None:
    assert not Check("energy", float("nan"), 1.0).passed
    assert not compare_counts("neighbors", np.array([3, 4]), np.array([3, 4, 5])).passed
    assert not compare_counts("neighbors", np.array([3, 4, 6]), np.array([3, 4, 5])).passed
    assert compare_counts("neighbors", np.array([3, 4, 5]), np.array([3, 4, 5])).passed


def test_displacement_takes_the_nearest_image_of_periodic_axes() -> None:
    bounds, periodic = np.array([[0.0, 10.0], [-1.0, 4.0], [0.0, 8.0]]), np.array([True, False, True])
    here = Frame(0, bounds, periodic, ("x", "y", "z"), np.array([[9.9, 3.9, 0.2]]))
    there = Frame(0, bounds, periodic, ("x", "y", "z"), np.array([[0.1, -0.9, 7.9]]))
    assert np.allclose(here.displacement(there), [[-0.2, 4.8, 0.3]])


def test_a_dump_is_read_with_box_and_step(tmp_path: Path) -> None:
    dump = tmp_path / "dump"
    dump.write_text(
        "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp ff ps\n0 1\n-2 3\n4 8\n"
        "ITEM: ATOMS id x y z\n1 0.5 1 5\n2 0.25 2 6\n",
        encoding="utf-8",
    )
    (frame,) = read_dump(dump)
    assert (frame.step, frame.lengths.tolist(), frame.periodic.tolist()) == (7, [1, 5, 4], [True, False, True])
    assert frame["z id"].tolist() == [[5, 1], [6, 2]]


def test_both_programs_refuse_a_wrong_script(tmp_path: Path) -> None:
    script = Script.of("units lj\nregoin box block 0 1 0 1 0 1").write(tmp_path / "wrong.in")
    with pytest.raises(LammpsError, match="regoin"):
        run_lammps(script)
    with pytest.raises(OctantError, match="regoin"):
        run_octant(script)
    assert call("run", script, cwd=tmp_path).returncode == 1
    assert call("run").returncode == 2
