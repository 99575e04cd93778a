"""Small scripts whose result must equal LAMMPS's to the last bit: where atoms are put, and with which velocities."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from validation.check import Check
from validation.dumps import Frame, full_precision, read_dump
from validation.lammps_runner import run_lammps
from validation.octant_runner import run_octant
from validation.scripts import Script

#: What a case's dump holds.
_COLUMNS = "id type x y z vx vy vz"

_BOX = """
units lj
lattice fcc 0.8442
region box block 0 4 0 5 0 3
create_box 2 box
create_atoms 1 box
mass 1 1.0
mass 2 2.75
"""

_TWO_KINDS = """
units lj
lattice sc 0.7 origin 0.25 0.5 0.1
region box block -2 3 -1 5 0 4
create_box 2 box
region lower block INF INF INF INF INF 1.9
region upper block INF INF INF INF 1.9 INF
create_atoms 2 region lower
create_atoms 1 region upper
mass 1 1.0
mass 2 2.75
group heavy type 2
group light type 1
"""

_EMPTY = """
units {units}
boundary {boundary}
{setup}
mass * 39.948
"""

_VELOCITIES = {
    "velocity, loop all": (_BOX, "velocity all create 1.44 87287"),
    "velocity, loop all, two masses": (_TWO_KINDS, "velocity all create 0.9 4711 loop all"),
    "velocity, loop local": (_TWO_KINDS, "velocity all create 1.44 87287 loop local"),
    "velocity, loop geom": (_BOX, "velocity all create 1.44 87287 loop geom"),
    "velocity, gaussian": (_BOX, "velocity all create 2.5 12345 dist gaussian"),
    "velocity, gaussian, loop geom": (_TWO_KINDS, "velocity all create 2.5 12345 dist gaussian loop geom"),
    "velocity, no mom": (_TWO_KINDS, "velocity all create 2.5 99 mom no"),
    "velocity, rot": (_TWO_KINDS, "velocity all create 2.5 99 mom yes rot yes"),
    "velocity, groups": (
        _TWO_KINDS,
        "velocity heavy create 0.3 7 loop geom\nvelocity light create 2.0 8 dist gaussian",
    ),
    "velocity, set, zero, scale": (
        _TWO_KINDS,
        "velocity all create 1.0 31 rot yes\nvelocity heavy set 0.5 NULL -0.25\nvelocity all zero linear\n"
        "velocity all zero angular\nvelocity all scale 0.7",
    ),
}

_LATTICES = {
    "sc, real units": (
        "real",
        "p p p",
        "lattice sc 3.7\nregion b block 0 5 0 4 0 3\ncreate_box 1 b\ncreate_atoms 1 box",
    ),
    "bcc, free sides": (
        "metal",
        "f f f",
        "lattice bcc 2.87\nregion b block -2 2 -1.5 2 0 3\ncreate_box 1 b\ncreate_atoms 1 box",
    ),
    "fcc, density": (
        "lj",
        "p p p",
        "lattice fcc 0.8442\nregion b block 0 5 0 4 0 3\ncreate_box 1 b\ncreate_atoms 1 box",
    ),
    "hcp": ("lj", "p p p", "lattice hcp 1.1\nregion b block 0 4 0 3 0 2\ncreate_box 1 b\ncreate_atoms 1 box"),
    "diamond": (
        "metal",
        "p f p",
        "lattice diamond 5.431\nregion b block 0 3 0 3 0 2\ncreate_box 1 b\ncreate_atoms 1 box",
    ),
    "custom": (
        "lj",
        "p p p",
        "lattice custom 1.3 a1 1 0 0 a2 0 1.2 0 a3 0 0 0.9 basis 0 0 0 basis 0.5 0.5 0.5 basis 0.25 0.75 0.1\n"
        "region b block 0 4 0 3 0 5\ncreate_box 1 b\ncreate_atoms 1 box",
    ),
    "orient, origin": (
        "metal",
        "p p p",
        "lattice fcc 3.615 origin 0.1 0.2 0.3 orient x 1 1 0 orient y -1 1 0 orient z 0 0 1\n"
        "region b block 0 4 0 4 0 3\ncreate_box 1 b\ncreate_atoms 1 box",
    ),
    "spacing": (
        "lj",
        "p p p",
        "lattice bcc 1.0 spacing 1.1 1.2 1.3\nregion b block 0 4 0 4 0 3\ncreate_box 1 b\ncreate_atoms 1 box",
    ),
    "sphere": (
        "lj",
        "p p p",
        "lattice fcc 0.9\nregion b block 0 6 0 6 0 6\ncreate_box 1 b\n"
        "region s sphere 3.1 2.9 3 2.2\ncreate_atoms 1 region s",
    ),
    "outside a cylinder": (
        "lj",
        "p p f",
        "lattice fcc 0.9\nregion b block 0 6 0 6 0 3\ncreate_box 1 b\n"
        "region c cylinder z 3 3 1.8 INF INF side out\ncreate_atoms 1 region c",
    ),
    "random": ("lj", "p p p", "region b block -3 6 0 7 1 5\ncreate_box 1 b\ncreate_atoms 1 random 150 4242 NULL"),
    "random in a region": (
        "lj",
        "p p p",
        "region b block -3 6 0 7 1 5\ncreate_box 1 b\nregion s sphere 1 3 3 1.9\ncreate_atoms 1 random 60 17 s",
    ),
    "single": (
        "lj",
        "f p s",
        "region b block -3 6 0 7 1 5\ncreate_box 1 b\ncreate_atoms 1 single 0.1 0.2 1.3 units box\n"
        "create_atoms 1 single 2.1 3.2 4.3 units box",
    ),
}


@dataclass(frozen=True)
class Case:
    """A script up to, but without, its pair style and run."""

    name: str
    text: str


def all_cases() -> list[Case]:
    """Velocities, then lattices."""
    cases = [Case(name, setup + velocity) for name, (setup, velocity) in _VELOCITIES.items()]
    for name, (units, boundary, setup) in _LATTICES.items():
        cases.append(Case(f"lattice, {name}", _EMPTY.format(units=units, boundary=boundary, setup=setup)))
    return cases


def atoms_by_lammps(case: Case, scratch: Path) -> Frame:
    """Ids, types, positions and velocities as LAMMPS creates them. Raises LammpsError."""
    script, dump = _dumped(case, scratch, "lammps")
    run_lammps(script)
    return read_dump(dump)[0]


def compare_case(case: Case, theirs: Frame, scratch: Path, *, backend: str = "cpu") -> Check:
    """Ids, types, positions and velocities of octant beside LAMMPS's; ``value``: how many numbers differ."""
    script, dump = _dumped(case, scratch, "octant")
    run_octant(script, backend=backend)
    ours = read_dump(dump)[0]
    if ours.values.shape != theirs.values.shape:
        return Check(case.name, float("inf"), 0.0, f"{len(ours.values)} atoms, LAMMPS has {len(theirs.values)}")
    different = int((ours.values != theirs.values).sum()) + int((ours.bounds != theirs.bounds).sum())
    largest = np.abs(ours.values - theirs.values).max()
    return Check(case.name, different, 0.0, f"{len(theirs.values)} atoms, largest difference {largest:.1e}")


def _dumped(case: Case, scratch: Path, program: str) -> tuple[Path, Path]:
    """The case as a script for one program, and the dump that it writes."""
    dump = scratch / f"{program}.dump"
    # Forces play no part: the shortest cutoff that keeps both programs content.
    end = ("pair_style lj/cut 1.0", "pair_coeff * * 1.0 0.5", *full_precision(1, dump, _COLUMNS), "run 0")
    return Script.of(case.text).then(*end).write(scratch / f"{program}.in"), dump
