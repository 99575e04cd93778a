"""The log file, as the programs read it that people read LAMMPS's logs with."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

from validation.lammps_runner import run_lammps
from validation.octant_runner import run_octant
from validation.scripts import Script

#: Two runs with different columns and thermo intervals, dangerous builds in both, a printed line between them.
SCENE = Script.of("""
    units lj
    atom_style atomic
    lattice fcc 0.8442
    region box block 0 4 0 4 0 4
    create_box 1 box
    create_atoms 1 box
    mass 1 1.0
    velocity all create 3.0 87287
    pair_style lj/cut 2.5
    pair_coeff 1 1 1.0 1.0
    neighbor 0.3 bin
    neigh_modify every 20 delay 0 check yes
    fix motion all nve
    thermo 10
    run 50
    print "between two runs"
    thermo_style custom step temp epair etotal press vol
    thermo 7
    run 30
""")

#: Number of rows and columns of the two tables: the last step is always printed.
TABLES = [
    (6, ["Step", "Temp", "E_pair", "E_mol", "TotEng", "Press"]),
    (6, ["Step", "Temp", "E_pair", "TotEng", "Press", "Volume"]),
]

Tables = list[dict[str, list[float]]]


def by_pymatgen(path: Path) -> Tables:
    from pymatgen.io.lammps.outputs import parse_lammps_log

    return [{name: list(table[name]) for name in table.columns} for table in parse_lammps_log(str(path))]


def by_lammps_logfile(path: Path) -> Tables:
    import lammps_logfile

    log = lammps_logfile.File(str(path))
    return [{name: list(log.get(name, run_num=run)) for name in columns} for run, (_, columns) in enumerate(TABLES)]


def by_lammps_formats(path: Path) -> Tables:
    from lammps.formats import LogFile

    return LogFile(str(path)).runs


READERS: dict[str, Callable[[Path], Tables]] = {
    "pymatgen": by_pymatgen,
    "lammps-logfile": by_lammps_logfile,
    "lammps.formats": by_lammps_formats,
}


@pytest.fixture(scope="module")
def logs(tmp_path_factory) -> dict[str, Path]:
    """The log of the same script by both programs."""
    folder = tmp_path_factory.mktemp("logs")
    script = SCENE.write(folder / "logs.in")
    run_lammps(script, log=folder / "log.lammps")
    run_octant(script, log=folder / "log.octant")
    return {"LAMMPS": folder / "log.lammps", "octant": folder / "log.octant"}


# LAMMPS's own log is read as well: where a reader fails on it too, the reader is at fault.
@pytest.mark.parametrize("program", ["LAMMPS", "octant"])
@pytest.mark.parametrize("reader", READERS)
def test_log_is_read(reader: str, program: str, logs: dict[str, Path]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tables = READERS[reader](logs[program])
    assert len(tables) == len(TABLES)
    for table, (rows, columns) in zip(tables, TABLES, strict=True):
        assert list(table) == columns
        assert {len(values) for values in table.values()} == {rows}
    assert [float(step) for step in tables[0]["Step"]] == [0, 10, 20, 30, 40, 50]
    assert [float(step) for step in tables[1]["Step"]] == [50, 56, 63, 70, 77, 80]


@pytest.mark.parametrize("reader", READERS)
def test_readers_get_the_same_from_both(reader: str, logs: dict[str, Path]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ours, theirs = READERS[reader](logs["octant"]), READERS[reader](logs["LAMMPS"])
    for table, reference in zip(ours, theirs, strict=True):
        for name, values in reference.items():
            assert list(map(float, table[name])) == pytest.approx(list(map(float, values)), rel=1e-7), name


def test_frame_of_the_log(logs: dict[str, Path]) -> None:
    """The lines that programs search for, and nothing but rows inside a table."""
    lines = logs["octant"].read_text(encoding="utf-8").splitlines()
    memory = [
        index for index, line in enumerate(lines) if line.startswith("Per MPI rank memory allocation (min/avg/max) =")
    ]
    assert len(memory) == 2
    for start in memory:
        header = lines[start + 1].split()
        assert header[0] == "Step"
        end = next(index for index in range(start, len(lines)) if lines[index].startswith("Loop time of"))
        assert all(len(line.split()) == len(header) for line in lines[start + 2 : end])
    assert sum(line.startswith("Total wall time:") for line in lines[end:]) == 1
