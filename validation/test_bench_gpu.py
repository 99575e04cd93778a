"""The benchmark on a GPU, tried on the CPU: its tables and what is made of them. Never how fast it was."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

from validation.bench.gpu import figure, measure, page, tables
from validation.bench.gpu.plan import OCTANT, PLAIN, SCENES, Plan
from validation.bench.gpu.tables import Group, Spread
from validation.bench.gpu.worker import Worker
from validation.bench.rounds import Absent
from validation.bundle import make, speed
from validation.octant_runner import ROOT

TINY = Plan(
    sizes=(500,), rounds=2, melting=20, leg=0.02, checked=(4_000, 50, 50), backend="cpu", words=("--steps", "20")
)
STAMP = {"date": "2000-01-01", "commit": "abc"}


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the tables of a tiny run."""
    folder = tmp_path_factory.mktemp("gpu")
    assert measure.run(TINY, folder, STAMP) == []
    return folder


def test_every_round_leaves_its_rows(measured: Path) -> None:
    rows = tables.read(measured / tables.BENCH)
    plain = [row for row in rows if row["scene"] == PLAIN]
    assert [(row["turn"], row["precision"]) for row in plain] == [(t, p) for t in "01" for p in OCTANT]
    assert [row["scene"] for row in rows if row["scene"] != PLAIN] == [s for s in SCENES for _ in OCTANT]
    for row in rows:
        assert (row["date"], row["commit"], row["pairs_missing"], row["pairs_extra"]) == ("2000-01-01", "abc", "0", "0")
        assert float(row["matom_steps_per_s"]) > 0 and float(row["force_error_rms"]) < 1e-5 and row["drift"]


def test_page_and_figure_are_made_of_the_tables(measured: Path) -> None:
    page.write(measured)
    figure.write(measured)
    text = (measured / "speed.md").read_text(encoding="utf-8")
    for group in tables.groups(tables.read(measured / tables.BENCH), scene=PLAIN):
        line = next(line for line in text.splitlines() if line.startswith(f"| 500 | {group.precision} |"))
        assert f"{group.most('force_error_rms'):.1e}" in line and "0 / 0" in line
    for heading in ("Speed and error", "Stages", "Scenes", "What others reach"):
        assert f"## {heading}\n" in text
    # A cell more or less shifts a table.
    widths = [line.count("|") for line in text.splitlines() if line.startswith("|")]
    heads = [line.count("|") for line in text.splitlines() if line.startswith("|---")]
    assert set(widths) == set(heads)
    assert (measured / "speed.png").stat().st_size > 10_000 and (measured / "speed.svg").exists()


def test_the_figure_stands_without_openmm_and_drift(measured: Path, tmp_path: Path) -> None:
    rows = tables.read(measured / tables.BENCH)
    tables.write(tmp_path / tables.BENCH, [row | {"drift": "", "drift_error": "", "pairs_missing": ""} for row in rows])
    page.write(tmp_path)
    figure.write(tmp_path)
    text = (tmp_path / "speed.md").read_text(encoding="utf-8")
    assert "OpenMM did not run beside." in text and "## OpenMM" not in text
    assert page.lines([], [], [])[2] == "Nothing was measured."


def row(**cells: object) -> tables.Row:
    return {"scene": PLAIN, "atoms": "500", "precision": "mixed"} | {name: str(cell) for name, cell in cells.items()}


def test_rounds_become_a_spread() -> None:
    single = Group(tuple(row(matom_steps_per_s=v) for v in (3, 1, 2)))
    assert single.speed() == Spread(2, 1, 3)
    several = Group((row(matom_steps_per_s=2, matom_steps_per_s_least=1.5, matom_steps_per_s_most=4),))
    assert several.speed() == Spread(2, 1.5, 4)
    # 3/1, 1/2 and 2/4 round by round; of the medians where the rounds do not match.
    other = Group(tuple(row(matom_steps_per_s=v) for v in (1, 2, 4)))
    assert tables.ratio(single, other) == Spread(0.5, 0.5, 3)
    assert tables.ratio(several, other) == Spread(1, 1, 1)
    drift = Group((row(drift=1e-6, drift_error=2e-6), row(drift=3e-6, drift_error=4e-6), row(drift="", drift_error="")))
    assert drift.drift() == pytest.approx((2e-6, 3e-6))
    empty = Group((row(drift=""),))
    assert empty.drift() is None and empty.mean("drift") is None and empty.total("drift") is None


def test_peers_have_a_number_and_a_source() -> None:
    peers = tables.read(tables.PEERS)
    for peer in peers:
        assert float(peer["matom_steps_per_s"]) > 0 and int(peer["atoms"]) >= 4_000
        assert peer["source"] and peer["hardware"] and peer["date"]
        # The legend has a look for each.
        assert (peer["program"], peer["precision"]) in figure._PEERS
    assert {peer["program"] for peer in peers} == {"LAMMPS-KOKKOS", "HOOMD", "OpenMM", "RUMD", "HALMD"}
    series = [(peer["program"], peer["precision"], int(peer["atoms"])) for peer in peers]
    assert len(set(series)) == len(series)


def test_what_does_not_fit_is_said(tmp_path: Path) -> None:
    (tmp_path / tables.OPENMM).write_text("of an earlier run\n", encoding="utf-8")
    said = measure.run(TINY.changed(limit=0.0), tmp_path, STAMP)
    assert said and all(line.endswith("left out, the time was up") for line in said)
    assert not list(tmp_path.iterdir())


def test_a_refusal_is_a_failure(tmp_path: Path) -> None:
    said = measure.run(TINY.changed(sizes=[12]), tmp_path, STAMP)
    # Once: what fails with the fewest atoms is not tried with more.
    assert len(said) == 1 and "expected 500" in said[0]


def test_openmm_absent_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(Absent, match="not installed"):
        Worker("5x5x5", TINY)


@pytest.mark.skipif(importlib.util.find_spec("openmm") is None, reason="OpenMM is not installed")
def test_openmm_runs_legs(measured: Path) -> None:
    rows = tables.read(measured / tables.OPENMM)
    assert [(r["turn"], r["precision"], r["atoms"]) for r in rows] == [("0", "single", "500"), ("1", "single", "500")]
    for r in rows:
        assert float(r["matom_steps_per_s"]) > 0 and 1e-9 < float(r["force_error_rms"]) < 1e-4
    worker = Worker("5x5x5", TINY.changed(backend="cuda"))
    try:
        # Without the plugin or a GPU there is a reason; with both there are two precisions.
        assert len(worker.legs(100.0)) == 2
    except Absent as reason:
        assert "CUDA" in str(reason)
    finally:
        worker.close()


def test_the_bundle_carries_the_benchmark(tmp_path: Path) -> None:
    files = {path.relative_to(ROOT).as_posix() for pattern in make.FILES for path in ROOT.glob(pattern)}
    assert {"validation/bench/peers.csv", "validation/bench/gpu/__main__.py", "validation/bundle/speed.py"} <= files
    environment, said = speed.with_peers(tmp_path / "bundle", tmp_path, {"A": "b"})
    assert (environment, said) == ({"A": "b"}, "no wheels of OpenMM beside the bundle")
    broken = tmp_path / speed.PEERS / "openmm-1-py3-none-any.whl"
    broken.parent.mkdir()
    broken.write_bytes(b"no wheel")
    _, said = speed.with_peers(tmp_path / "bundle", tmp_path, {})
    assert said.startswith("OpenMM could not be installed")


def test_peers_are_pinned() -> None:
    text = (ROOT / "validation" / "bench" / "gpu" / "requirements.txt").read_text(encoding="utf-8")
    cpu = (ROOT / "validation" / "bench" / "requirements.txt").read_text(encoding="utf-8")
    (here,) = re.findall(r"^openmm==(\S+)$", text, re.MULTILINE)
    assert f"OpenMM-CUDA-13=={here}" in text and f"openmm=={here}" in cpu
