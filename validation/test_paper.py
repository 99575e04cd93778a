"""The particle system of Morillo et al. 2015 at its first step: both readings of its force beside LAMMPS, on the same points."""

from __future__ import annotations

import csv
import subprocess
from pathlib import Path

import numpy as np
import pytest

from validation.dumps import full_precision, read_dump
from validation.lammps_runner import run_lammps
from validation.octant_runner import ROOT, count_neighbors, find_binary, run_octant
from validation.scripts import Script, command

SCRIPTS = sorted((ROOT / "inputs" / "paper").glob("*.in"), key=lambda path: int(path.stem))

#: The force in LAMMPS's words: it has the spring, and a formula for the other.
LAMMPS_FORCE = {
    "spring": ("pair_style harmonic/cut", "pair_coeff 1 1 1800.0 1.0"),
    "inverse": ("pair_style lepton 1.0", 'pair_coeff 1 1 "-3600.0*log(r)"'),
}


def for_lammps(path: Path, *force: str) -> Script:
    """A script up to its run, with a force as LAMMPS knows it and without what LAMMPS lacks: second-order Euler."""
    kept: list[str] = []
    for line in Script.read(path).until_run().lines:
        if command(line) == "if":
            # One of several that ask for the force.
            kept += force if force[0] not in kept else ()
        elif not line.startswith("fix") or "${integrator}" not in line:
            kept.append(line)
    return Script(tuple(kept))


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_neighbors_are_those_of_lammps(path: Path, tmp_path: Path) -> None:
    script = for_lammps(path, *LAMMPS_FORCE["spring"]).then("run 0").write(tmp_path / "lammps.in")
    theirs = run_lammps(script, neighbors=True).neighbors
    assert theirs is not None
    # Atoms without a neighbor at the end of the ids are in neither array.
    ours = count_neighbors(path)
    assert (ours[: len(theirs)] == theirs).all()
    assert not ours[len(theirs) :].any()


def test_searches_and_edges_find_the_same_neighbors() -> None:
    path = SCRIPTS[3]
    expected = count_neighbors(path)
    octants = [f"{search}:{edge}" for search in ("octant", "trimmed", "midplane") for edge in (2, 2.52, 4)]
    standard = [f"standard:{edge}" for edge in (0.5, 1, 2, 2.52, 4)]
    others = ["standard+zorder", "octant:2.52+radix", "trimmed+zorder+radix"]
    for search in [*octants, *standard, *others, "brute"]:
        assert (count_neighbors(path, search=search) == expected).all(), search


@pytest.mark.parametrize("name", ["uniform", "liquid", "clustered", "dense"])
def test_neighbors_in_every_distribution_are_those_of_lammps(name: str, distributions: Path, tmp_path: Path) -> None:
    """Positions of the experiments, handed to LAMMPS; every search has found the counts that stand beside them."""
    table = np.loadtxt(distributions / f"particles-{name}.csv", delimiter=",", skiprows=1)
    with (distributions / "distributions.csv").open(encoding="utf-8", newline="") as file:
        row = next(row for row in csv.DictReader(file) if row["distribution"] == name)
    lengths = row["box"].split()
    data = ["particles", "", f"{len(table)} atoms", "1 atom types", ""]
    data += [f"0 {length} {axis}lo {axis}hi" for axis, length in zip("xyz", lengths, strict=True)]
    data += ["", "Atoms", "", *(f"{int(k)} 1 {x!r} {y!r} {z!r}" for k, x, y, z, _ in table.tolist())]
    (tmp_path / "particles.data").write_text("\n".join(data) + "\n", encoding="utf-8")
    side = "p" if name == "liquid" else "f"
    script = Script(
        (
            "units lj",
            f"boundary {side} {side} {side}",
            f"read_data {tmp_path / 'particles.data'}",
            "mass 1 1.0",
            "pair_style harmonic/cut",
            f"pair_coeff 1 1 1.0 {row['radius']}",
            "neighbor 0.0 bin",
            "neigh_modify every 1 delay 0 check no one 10000 page 200000",
            "run 0",
        )
    )
    theirs = run_lammps(script.write(tmp_path / "lammps.in"), neighbors=True).neighbors
    assert theirs is not None
    ours = table[:, 4].astype(int)
    assert (ours[: len(theirs)] == theirs).all() and ours.sum() > len(ours)
    assert not ours[len(theirs) :].any()


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("distributions")
    words = ["paper", "--quick", "--particles", "--backend", "cpu", "--rounds", "1", "--precision", "double", "--out", folder]
    subprocess.run([find_binary(), *words], capture_output=True, check=True)
    return folder


@pytest.mark.parametrize("path", SCRIPTS[:5], ids=lambda path: path.stem)
@pytest.mark.parametrize("force", LAMMPS_FORCE)
def test_forces_and_energy_are_those_of_lammps(path: Path, force: str, tmp_path: Path) -> None:
    dumps = [tmp_path / "lammps.dump", tmp_path / "octant.dump"]
    exact = "thermo_modify format float %.17g"
    script = for_lammps(path, *LAMMPS_FORCE[force]).then(*full_precision(1, dumps[0]), exact, "run 0")
    theirs = run_lammps(script.write(tmp_path / "lammps.in"))
    script = Script.read(path).until_run().then(*full_precision(1, dumps[1]), exact, "run 0")
    ours = run_octant(script.write(tmp_path / "octant.in"), {"force": force})
    a, b = (read_dump(dump)[0] for dump in dumps)
    assert (a["id x y z"] == b["id x y z"]).all()
    f = a["fx fy fz"]
    # Near pairs of the inverse force: a particle's error is judged by the size of its own force.
    scale = np.maximum(np.sqrt((f**2).mean()), np.abs(f).max(axis=1, keepdims=True))
    assert (np.abs(b["fx fy fz"] - f) / scale).max() < 1e-12
    energies = [float(run.runs[-1].column("E_pair")[0]) for run in (theirs, ours)]
    assert energies[1] == pytest.approx(energies[0], rel=1e-12)


@pytest.mark.parametrize("spacing", ["r", "rsq"])
@pytest.mark.parametrize("force", LAMMPS_FORCE)
def test_lammps_reads_the_table_that_is_written(force: str, spacing: str, tmp_path: Path) -> None:
    path, rows, inner, outer = SCRIPTS[0], 200_000, 0.02, 0.999999999
    table, dumps = tmp_path / "force.table", [tmp_path / "lammps.dump", tmp_path / "octant.dump"]
    write = f"pair_write 1 1 {rows} {spacing} {inner} {outer} {table} FORCE"
    script = Script.read(path).until_run().then(write, *full_precision(1, dumps[1]), "run 0")
    ours = run_octant(script.write(tmp_path / "octant.in"), {"force": force})
    assert f"Creating table file {table}" in ours.log
    style = (f"pair_style table linear {rows}", f"pair_coeff 1 1 {table} FORCE {outer}")
    script = for_lammps(path, *style).then(*full_precision(1, dumps[0]), "run 0")
    theirs = run_lammps(script.write(tmp_path / "lammps.in"))
    a, b = (read_dump(dump)[0]["fx fy fz"] for dump in dumps)
    scale = np.maximum(np.sqrt((a**2).mean()), np.abs(a).max(axis=1, keepdims=True))
    # LAMMPS interpolates between rows, linearly in r^2 whatever the file's spacing.
    assert (np.abs(a - b) / scale).max() < 2e-5
    energies = [float(run.runs[-1].column("E_pair")[0]) for run in (theirs, ours)]
    assert energies[1] == pytest.approx(energies[0], rel=1e-6)
