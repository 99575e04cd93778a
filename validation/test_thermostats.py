"""A liquid under a thermostat: its means beside LAMMPS's, whose random numbers, and so whose trajectories, are others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from validation.lammps_runner import run_lammps
from validation.octant_runner import run_octant

_LIQUID = """
units lj
lattice fcc 0.8
region box block 0 5 0 5 0 5
create_box 1 box
create_atoms 1 box
mass 1 1.0
velocity all create 2.2 87287 loop geom
pair_style lj/cut 2.5
pair_coeff 1 1 1.0 1.0
pair_modify tail yes
{fixes}
timestep 0.004
thermo_style custom step temp pe press
run 1000
thermo 50
run 5000
"""

_BATHS = {
    "langevin": "fix bath all langevin 1.1 1.1 0.2 4711\nfix move all nve",
    "nvt": "fix bath all nvt temp 1.1 1.1 0.2",
}


@pytest.mark.parametrize("bath", _BATHS)
def test_means_are_those_of_lammps(bath: str, tmp_path: Path) -> None:
    script = tmp_path / "liquid.in"
    script.write_text(_LIQUID.format(fixes=_BATHS[bath]), encoding="utf-8")
    theirs = run_lammps(script).runs[-1]
    ours = run_octant(script).runs[-1]
    for column in ("Temp", "PotEng", "Press"):
        values = [np.array([float(x) for x in run.column(column)])[1:] for run in (theirs, ours)]
        # Rows are a damping time apart; means of blocks of ten of them stand for independent ones.
        blocks = [rows.reshape(-1, 10).mean(axis=1) for rows in values]
        error = np.sqrt(sum(means.var(ddof=1) / len(means) for means in blocks))
        # Standard errors of ten blocks each: 1 in 3000 differ by more than 4.5 of Student's with 18 degrees of freedom.
        difference = blocks[0].mean() - blocks[1].mean()
        assert abs(difference) < 4.5 * error, f"{column}: {difference} +- {error}"
    temperature = np.array([float(x) for x in ours.column("Temp")])[1:]
    # 1500 degrees of freedom, a hundred rows; and the error of the step, (omega dt)^2 / 8 with an omega of about 30.
    assert abs(temperature.mean() - 1.1) < 4.0 * 1.1 * np.sqrt(2 / (1500 * len(temperature))) + 2e-3


_TWICE = {
    "nvt, nve": ["all nvt temp 1.0 1.2 0.1", "all nve"],
    "nve, nvt": ["all nve", "all nvt temp 1.0 1.2 0.1"],
    "nvt, nvt": ["all nvt temp 1.0 1.2 0.1", "all nvt temp 0.8 0.8 0.2"],
    "nvt, nve/limit": ["all nvt temp 1.0 1.2 0.1", "all nve/limit 0.01"],
    "groups that overlap": ["left nvt temp 1.0 1.2 0.1", "some nvt temp 1.0 1.2 0.1", "all nve"],
    "groups that do not": ["left nvt temp 1.0 1.2 0.1", "right nve"],
    "nve, nve": ["all nve", "all nve"],
}

_CRYSTAL = """
units lj
lattice fcc 0.8442
region box block 0 4 0 4 0 4
create_box 1 box
create_atoms 1 box
mass 1 1.0
velocity all create 1.44 87287 loop geom
pair_style lj/cut 2.5
pair_coeff 1 1 1.0 1.0
region left block 0 2.1 0 4 0 4
group left region left
group right subtract all left
group some id 1:100
{fixes}
timestep 0.002
thermo_style custom step temp epair press ecouple
thermo 10
run 20
"""


@pytest.mark.parametrize("fixes", _TWICE)
def test_fixes_that_integrate_the_same_atoms_take_turns_as_in_lammps(fixes: str, tmp_path: Path) -> None:
    script = tmp_path / "crystal.in"
    lines = [f"fix {k} {words}" for k, words in enumerate(_TWICE[fixes])]
    script.write_text(_CRYSTAL.format(fixes="\n".join(lines)), encoding="utf-8")
    theirs, ours = run_lammps(script).runs[-1], run_octant(script, precision="double").runs[-1]
    for column in ("Step", "Temp", "E_pair", "Press", "Ecouple"):
        assert ours.column(column) == theirs.column(column), column
