"""The benchmark: it measures what it says on tiny liquids, and what it writes can be read. Never how fast it was."""

from __future__ import annotations

import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from validation.bench import __main__ as command_line
from validation.bench import figures, machine, page
from validation.bench.contestants import Lammps, Octant, OpenMM, loop_cost
from validation.bench.liquid import Atoms, Liquids
from validation.bench.plan import MODES, Plan, atoms
from validation.bench.reference import all_pairs
from validation.bench.rounds import Absent, Sample, in_turns
from validation.bench.rows import ABSENT, COLUMNS, COST, Row, Rows
from validation.bench.sections import SECTIONS, errors, features, ratios, sizes, stages
from validation.markdown import number
from validation.octant_runner import find_binary

TINY = replace(
    Plan.quick(2),
    rounds=2,
    sizes=(4, 5),
    main=5,
    melting=40,
    atom_steps=2e4,
    drift_size=4,
    drift_steps=100,
    all_atoms=300,
)

#: What an older binary says when it is asked for an arithmetic that it lacks.
_REFUSAL = "ERROR: this version of octant computes in double precision only"


@pytest.fixture(scope="module")
def liquids(tmp_path_factory: pytest.TempPathFactory) -> Liquids:
    return Liquids(tmp_path_factory.mktemp("liquids"), TINY)


@pytest.fixture(scope="module")
def rows(liquids: Liquids) -> Rows:
    """Every section, measured once."""
    measured = [row for section in SECTIONS for row in section.measure(TINY, liquids)]
    return Rows(measured).stamped("a machine, 2 cores, avx2", "2000-01-01", "abc")


@pytest.fixture
def older(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A binary that knows double precision alone and says nothing of instruction sets."""
    script = tmp_path / "octant"
    script.write_text(
        "#!/bin/sh\n"
        f'case "$*" in *mixed*|*single*) echo "{_REFUSAL}" >&2; exit 1;; esac\n'
        f'exec "{find_binary()}" "$@"\n',
        encoding="utf-8",
    )
    script.chmod(0o755)
    monkeypatch.setenv("OCTANT", str(script))


def by_hand(positions: np.ndarray, length: float, cutoff: float) -> np.ndarray:
    """Forces as one would write them down: every pair, every image, no thought of speed."""
    forces = np.zeros_like(positions)
    shifts = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
    for one, here in enumerate(positions):
        for other, there in enumerate(positions):
            for shift in shifts:
                d = here - there - length * np.array(shift)
                r = math.sqrt(d @ d)
                if one != other and r < cutoff:
                    forces[one] += (48 / r**13 - 24 / r**7) * d / r
    return forces


def test_reference_forces_are_those_by_hand() -> None:
    grid = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    positions = 1.8 * grid + np.random.default_rng(1).uniform(0, 0.6, (27, 3)) - 7
    bounds = np.array([[-7.0, -1.6]] * 3)
    exact = all_pairs(positions, bounds)
    assert np.allclose(exact.forces, by_hand(positions, 5.4, 2.5), rtol=1e-12, atol=1e-12)
    some = all_pairs(positions, bounds, [3, 20])
    assert np.array_equal(some.forces, exact.forces[[3, 20]])
    with pytest.raises(ValueError, match="two cutoffs"):
        all_pairs(positions, bounds, cutoff=3.0)


def test_reference_notices_a_pair_at_the_cutoff() -> None:
    positions = np.array([[1.0, 1, 1], [1, 1, 3.5 + 1e-7], [8, 8, 8]])
    edge = all_pairs(positions, np.array([[0.0, 12]] * 3)).edge
    assert edge[:2] == pytest.approx(1e-7, rel=1e-3)
    assert edge[2] == math.inf


def test_error_is_relative_to_the_rms_force() -> None:
    exact = np.array([[3.0, 0, 0], [0, 4, 0]])
    rms, worst = errors.relative_errors(exact + [[0, 0, 0], [0, 0, 0.5]], exact)
    assert (rms, worst) == pytest.approx((0.5 / 5, 0.5 / math.sqrt(12.5)))


def test_a_data_file_is_read_as_written(liquids: Liquids, tmp_path: Path) -> None:
    liquid = liquids.atoms(4)
    assert liquid.positions.shape == liquid.velocities.shape == (atoms(4), 3)
    again = Atoms.read(liquid.two_types().write(tmp_path / "data"))
    assert np.array_equal(again.positions, liquid.positions)
    assert np.array_equal(again.velocities, liquid.velocities)
    assert np.bincount(again.types).tolist() == [0, atoms(4) // 2, atoms(4) // 2]
    far = liquid.moved(1e6)
    assert ((far.positions >= far.bounds[:, 0]) & (far.positions < far.bounds[:, 1])).all()


def test_turns_alternate_and_leave_out_the_absent() -> None:
    calls: list[str] = []

    def runner(name: str):
        def run() -> Sample:
            calls.append(name)
            if name == "c":
                raise Absent("no c here")
            return Sample(float(len(calls)))

        return run

    turns = in_turns({name: runner(name) for name in "abc"}, 3, "test")
    assert "".join(calls) == "abc" + "ba" + "ab"
    assert turns.absent == {"c": "no c here"}
    assert turns.costs("c") == []
    assert turns.ratios("b", "a") == [2 / 1, 4 / 5, 7 / 6]


def test_loop_time_of_a_log() -> None:
    first = "Loop time of 9 on 1 procs for 1 steps with 1 atoms\n"
    last = "Loop time of 0.5 on 2 procs for 100 steps with 4000 atoms\n"
    assert loop_cost(first + last) == pytest.approx(0.5e9 / 400_000)


def test_stages_of_older_and_newer_reports() -> None:
    timing = {"loop_s": 10.0, "stages": {"pair": 6.0, "neighbor": 3.0, "modify": 0.5, "output": 0.25, "other": 0.25}}
    assert stages.shares({"timing": timing}) == pytest.approx(
        {"list": 0.3, "pair": 0.6, "modify": 0.05, "output": 0.025, "other": 0.025}
    )
    report = {"atoms": 10, "timing": timing, "neighbors": {"per_atom": 40.0, "builds": 5}}
    assert stages.derived(report, 100, 1, 1e9) == pytest.approx(
        {"pairs": 40, "pair rate": 40 * 1000 / 6 / 1e6, "cycles a pair": 6e9 / 1000 / 40}
    )
    timing["stages"] |= {"sort": 0.5, "list": 2.0}
    assert stages.shares({"timing": timing})["check"] == pytest.approx(0.05)
    report["neighbors"] |= {"list_entries_per_atom": 100.0, "distance_tests_per_atom": 400.0}
    report["memory"] = {"bytes_per_atom": 800}
    derived = stages.derived(report, 100, 2, 1e9)
    assert derived["cycles an entry"] == pytest.approx(2 * 6e9 / 1000 / 100)
    assert derived["cycles a test"] == pytest.approx(2 * 2e9 / (5 * 10 * 400))
    assert derived["memory"] == 800


def test_every_section_measures(rows: Rows) -> None:
    assert rows.distinct("section") == [section.NAME for section in SECTIONS]
    assert {row.value for row in rows.where(section=ratios.NAME)} >= {COST, "speed over LAMMPS opt"}
    assert rows.where(section=ratios.NAME, value=COST, contestant="octant double").distinct("threads") == [1, 2]
    assert rows.where(section=sizes.NAME, value=COST).distinct("atoms") == [atoms(4), atoms(5)]
    assert rows.where(section=stages.NAME, value="share of pair")
    assert len(rows.where(section=features.NAME, value="cost over plain")) >= 8
    for row in rows.where(value=COST):
        assert 0 < row.min <= row.q1 <= row.median <= row.q3 and row.rounds == TINY.rounds, row
    for row in rows.where(value=ABSENT):
        assert row.unit and not row.unit.startswith("/"), row


def test_forces_of_every_program_are_right(rows: Rows) -> None:
    forces = rows.where(section=errors.NAME, value=errors.HERE)
    assert {"octant double", "LAMMPS opt", "LAMMPS omp", "LAMMPS mpi"} <= set(forces.distinct("contestant"))
    for row in forces:
        exact = row.contestant.startswith("LAMMPS") or row.contestant == "octant double"
        assert row.error_rms < (1e-12 if exact else 1e-3), row
    assert rows.where(section=errors.NAME, value=errors.MOVED)
    assert rows.where(section=errors.NAME, value=errors.DRIFT)


def test_results_are_written(rows: Rows, tmp_path: Path) -> None:
    page.write(tmp_path, rows, quick=True)
    assert (tmp_path / "bench.csv").read_text(encoding="utf-8").splitlines()[0] == ",".join(COLUMNS)
    read = Rows.read(tmp_path / "bench.csv")
    assert len(read) == len(rows)
    assert {(row.machine, row.date, row.commit) for row in read} == {("a machine, 2 cores, avx2", "2000-01-01", "abc")}
    known = read.first(section=ratios.NAME, contestant="octant double", value=COST)
    assert known and 0 < known.error_rms <= known.error_max
    text = (tmp_path / "bench.md").read_text(encoding="utf-8")
    for heading in ("Speed", "Size", "Force error", "Stages", "Features", "Instruction sets", "Reading the numbers"):
        assert f"## {heading}\n" in text
    assert "double, one core: " in text and "x (" in text
    for name in ("bench.png", "bench.svg"):
        assert (tmp_path / name).stat().st_size > 5_000
    lines = page.readme_lines(rows)
    assert len({line.count("|") for line in lines if line.startswith("|")}) == 1


def test_half_a_table_gives_a_page(rows: Rows, tmp_path: Path) -> None:
    page.write(tmp_path, rows.where(section=sizes.NAME), quick=False)
    text = (tmp_path / "bench.md").read_text(encoding="utf-8")
    assert "## Size\n" in text and "## Speed\n" not in text and "Quick" not in text


def test_an_older_binary_is_absent_in_what_it_lacks(older: None, liquids: Liquids) -> None:
    data = liquids.data(4)
    assert Octant("double", 1).time(data, 20).cost > 0
    with pytest.raises(Absent, match="double precision only"):
        Octant("mixed", 1).time(data, 20)
    found = features.measure(replace(TINY, rounds=1, main=4), liquids)
    assert found.first(value=ABSENT, contestant="octant mixed")
    assert found.first(value=COST, contestant=f"octant double: {features.BASE}")


def test_absent_programs_say_why(liquids: Liquids, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(Absent):
        Octant("double", 1, "no such set").time(liquids.data(4), 20)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(Absent, match="no lmp"):
        Lammps("opt", 1).time(liquids.data(4), 20)


@pytest.mark.skipif(importlib.util.find_spec("openmm") is None, reason="OpenMM is not installed")
def test_openmm_runs_the_same_liquid(liquids: Liquids) -> None:
    data, liquid = liquids.data(5), liquids.atoms(5)
    assert OpenMM(1).time(data, 20).cost > 0
    exact = all_pairs(liquid.positions, liquid.bounds)
    rms, _ = errors.relative_errors(OpenMM(1).forces(data), exact.forces)
    assert 1e-9 < rms < 1e-4


def test_pareto_front() -> None:
    assert figures.pareto([(1, 5), (2, 3), (3, 4), (2, 6), (4, 1)]) == [(1, 5), (2, 3), (4, 1)]


def test_machine_tells_its_clock() -> None:
    rate, source = machine.clock()
    assert source
    assert rate == 0 or 1e8 < rate < 1e10
    assert machine.physical_cores() >= 1


def test_numbers_are_plain() -> None:
    shown = [number(value) for value in (0.0, 0.12345, 12.345, 999.6, 12345.6, 4.5e-15, math.nan)]
    assert shown == ["0", "0.123", "12.3", "1 000", "12 300", "4.5e-15", "-"]


def test_a_row_holds_median_and_quartiles() -> None:
    row = Row.of("s", "c", 1, 1, "v", "u", [5.0, 1.0, 3.0, 4.0, 2.0])
    assert (row.min, row.q1, row.median, row.q3, row.rounds) == (1, 2, 3, 4, 5)


def test_command_line(liquids: Liquids, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A section measured alone leaves the others of an earlier call as they are."""
    Rows([Row("sizes", "octant double", 500, 1, COST, "ns/atom-step", 9, 9, 9, 9, 1)]).write(tmp_path / "bench.csv")
    words = ["--quick", "--sizes", "4", "--rounds", "1", "--threads", "1", "--only", "stages", "--floor", "double=2"]
    monkeypatch.setattr(sys, "argv", ["bench", *words, "--output", str(tmp_path)])
    assert command_line.main() == 0
    read = Rows.read(tmp_path / "bench.csv")
    assert read.distinct("section") == ["sizes", "stages"]
    assert read.first(section="stages", contestant="octant double", value="floor").median == 2
    assert set(read.where(section="stages", value=COST).distinct("contestant")) <= {
        *(f"octant {mode}" for mode in MODES),
        "octant mixed, every 1, check yes",
    }
