"""The bundle's own judgement: what counts as passed, failed and skipped, and the summary of it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from validation.bundle import comparison, device, engine, make, paper, sanitizer, suites, summary
from validation.bundle.outcome import FAILED, PASSED, SKIPPED, Done, Outcome, call
from validation.octant_runner import ROOT, find_binary
from validation.paper.results import NAMES

GPU = device.read(
    "octant 0.1.0\nbackends      cpu (2 cores; avx2)\n"
    "              cuda device 0: NVIDIA H100, compute capability 9.0, 80 GiB\n"
    "              NVRTC 13.0\nprecisions    single\n",
    "580.1",
)
NO_GPU = device.read("octant 0.1.0\n              no cuda: there is no NVIDIA driver on this machine\n", "none")

SUITE = """
running 4 tests
test forces ... ok
test kernels ... ok
test long ... ignored
test sums ... ok

successes:

---- kernels stdout ----
skipped: there is no NVRTC

---- sums stdout ----
worst 1e-7


successes:
    forces
    kernels
    sums

test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.20s
"""


def counts(outcome: Outcome) -> tuple[str, int, int, int]:
    return outcome.verdict, outcome.passed, outcome.failed, outcome.skipped


def test_the_device_is_read() -> None:
    assert GPU.present and GPU.cards == ["0: NVIDIA H100, compute capability 9.0, 80 GiB"] and GPU.nvrtc == "13.0"
    assert not NO_GPU.present and NO_GPU.missing == "no CUDA device: there is no NVIDIA driver on this machine"
    assert device.read("octant 0.1.0\n", "none").missing.startswith("no CUDA device: ")


def test_a_test_that_says_skipped_did_not_pass() -> None:
    outcome = suites.judge("physics", Done(0, SUITE, 0.2), "log")
    assert counts(outcome) == (PASSED, 2, 0, 2)
    assert outcome.detail == "there is no NVRTC"
    alone = SUITE.replace("worst 1e-7", "skipped: no CUDA device").replace("3 passed", "2 passed")
    assert suites.judge("physics", Done(0, alone.replace("test forces ... ok\n", ""), 0.2), "log").verdict == SKIPPED


def test_suites_fail() -> None:
    broken = SUITE.replace("test forces ... ok", "test forces ... FAILED").replace(
        "ok. 3 passed; 0", "FAILED. 2 passed; 1"
    )
    outcome = suites.judge("physics", Done(101, broken, 0.2), "log")
    assert counts(outcome) == (FAILED, 1, 1, 2) and outcome.detail == "forces"
    for done in (Done(-11, "running 4 tests\n", 0.1), Done(None, SUITE, 9.0), Done(1, SUITE, 0.1), Done(0, "", 0.1)):
        assert suites.judge("physics", done, "log").verdict == FAILED


def test_engines_without_a_gpu_are_skipped_and_run_on_the_cpu(tmp_path: Path) -> None:
    binary = tmp_path / "suite"
    binary.write_text('#!/bin/sh\necho "$OCTANT_TEST_BACKEND, $OCTANT_TEST_ROOT"\n', encoding="utf-8")
    binary.chmod(0o755)
    suite = suites.Suite("physics", "suite", True)

    def said(found: device.Device, suite: suites.Suite) -> list[tuple[str, str]]:
        inherited = {**os.environ, "OCTANT_TEST_BACKEND": "nonsense"}
        outcomes = suites.run([suite], tmp_path, tmp_path, tmp_path, inherited, found, "cuda")
        logs = [
            (outcome.name, (tmp_path / outcome.log).read_text() if outcome.log else outcome.verdict)
            for outcome in outcomes
        ]
        return [(name, text.strip()) for name, text in logs]

    assert said(GPU, suite) == [("physics on cuda", f"cuda, {tmp_path}")]
    assert said(NO_GPU, suite) == [("physics on cuda", SKIPPED), ("physics on cpu", f"cpu, {tmp_path}")]
    assert said(GPU, replace(suite, engines=False)) == [("physics", f", {tmp_path}")]


def test_a_process_that_hangs_is_ended(tmp_path: Path) -> None:
    done = call(["sh", "-c", "echo begun; sleep 60 & wait"], tmp_path / "log", os.environ, 0.5, tmp_path)
    assert done.status is None and done.output == "begun\n" and done.seconds < 10


@pytest.mark.parametrize(
    ("status", "output", "verdict"),
    [
        (0, "========= ERROR SUMMARY: 0 errors\n", PASSED),
        (0, "========= RACECHECK SUMMARY: 0 hazards displayed (0 errors, 0 warnings)\n", PASSED),
        (86, "========= ERROR SUMMARY: 10 errors\n", FAILED),
        (0, "========= ERROR SUMMARY: 10 errors\n", FAILED),
        (1, "========= ERROR SUMMARY: 0 errors\n", FAILED),
        (0, "Loop time of 1\n", FAILED),
        (None, "========= ERROR SUMMARY: 0 errors\n", FAILED),
    ],
)
def test_the_sanitizer_is_judged(status: int | None, output: str, verdict: str) -> None:
    assert sanitizer.judge("memcheck", Done(status, output, 1.0), "log").verdict == verdict


#: In place of compute-sanitizer: runs the scene on the CPU and finds nothing.
NO_SANITIZER = """#!/bin/sh
shift 4
"$1" $(shift; echo "$*" | sed 's/--backend cuda/--backend cpu/') || exit
echo "========= ERROR SUMMARY: 0 errors"
"""


def test_sanitizer_scenes_are_small_and_build_lists(tmp_path: Path) -> None:
    for folder in ("inputs", "validation"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "octant").symlink_to(find_binary())
    tool = tmp_path / "bin" / "compute-sanitizer"
    tool.write_text(NO_SANITIZER, encoding="utf-8")
    tool.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tool.parent}:{os.environ['PATH']}"}
    outcomes = list(sanitizer.run(tmp_path, tmp_path, tmp_path, environment, GPU, "cuda"))
    runs = sum(len(scene.precisions) for scene in sanitizer.SCENES)
    assert len({outcome.log for outcome in outcomes}) == runs * len(sanitizer.TOOLS) == len(outcomes)
    assert {outcome.verdict for outcome in outcomes} == {PASSED}
    for outcome in outcomes:
        text = (tmp_path / outcome.log).read_text(encoding="utf-8")
        atoms, builds = re.search(r"steps with (\d+) atoms", text), re.search(r"list builds = (\d+)", text)
        assert atoms and builds and int(atoms[1]) < 600 and int(builds[1]) >= 3, outcome.name
    (skipped,) = sanitizer.run(tmp_path, tmp_path, tmp_path, environment, NO_GPU, "cuda")
    assert (skipped.verdict, skipped.detail) == (SKIPPED, NO_GPU.missing)


def test_the_experiments_of_the_paper_leave_their_files(tmp_path: Path) -> None:
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "octant").symlink_to(find_binary())

    def run(found: device.Device, backend: str, limit: float = 100.0) -> Outcome:
        (outcome,) = paper.run(tmp_path, tmp_path, tmp_path, os.environ, found, backend, limit, (500,), True)
        return outcome

    done = run(NO_GPU, "cpu")
    assert (done.verdict, done.detail) == (PASSED, "") and done.seconds < 100
    assert {path.stem for path in (tmp_path / "paper").glob("*.csv")} == set(NAMES)
    assert "Figure 5" in (tmp_path / done.log).read_text(encoding="utf-8")
    assert (run(NO_GPU, "cuda").verdict, run(NO_GPU, "cuda").detail) == (SKIPPED, NO_GPU.missing)
    late = run(GPU, "cpu", 0.2)
    assert (late.verdict, late.detail) == (FAILED, "did not end in time")


BENCH = """
Benchmarking list/octant: Analyzing
list/octant             time:   [1.5000 ms 2.0000 ms 12.5000 ms]
                        thrpt:  [1.1482 Gelem/s 1.1483 Gelem/s 1.1485 Gelem/s]
Found 1 outliers among 10 measurements (10.00%)
Benchmarking list, cuda/octant: Analyzing
list, cuda/octant
                        time:   [10.414 µs 10.417 µs 10.419 µs]
                        change: [-1.0% +0.1% +1.0%] (p = 0.30 > 0.05)
set-up/4000             time:   [900.00 ns 1.0000 µs 1.1000 µs]
"""


def test_times_of_benches_become_a_page() -> None:
    found = engine.read(BENCH)
    assert [(one.group, one.case, one.time) for one in found] == [
        ("list", "octant", 2000.0),
        ("list, cuda", "octant", 10.417),
        ("set-up", "4000", 1.0),
    ]
    page = engine.page("search", "2026-01-01, commit abc, a card.", found)
    assert "| octant | 2 000 (1 500 to 12 500) | 10.42 (10.41 to 10.42) |" in page
    # Cases that groups do not share are tables of their own.
    assert "| list | list, cuda |" in page and "| 4000 | 1.000 (0.9000 to 1.100) |" in page


@pytest.mark.parametrize(
    ("script", "verdict", "detail"),
    [
        ("cat bench", PASSED, ""),
        ("cat bench; exit 3", FAILED, "exit status 3"),
        ("echo nothing", FAILED, "no time in it"),
        ("cat bench; echo 'no search is measured on a GPU: no driver'", SKIPPED, "no driver"),
    ],
)
def test_benches_are_judged(tmp_path: Path, script: str, verdict: str, detail: str) -> None:
    (tmp_path / "bench").write_text(BENCH, encoding="utf-8")
    (tmp_path / "search").write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    (tmp_path / "search").chmod(0o755)
    about = {"date": "2026-01-01T00:00:00", "commit": "abc", "card": "a card"}
    (outcome,) = engine.run(tmp_path, tmp_path / "results", tmp_path, os.environ, "cuda", ["search"], about)
    assert (outcome.verdict, outcome.detail) == (verdict, detail)
    assert "2026-01-01, commit abc, a card." in (tmp_path / "results" / "engine" / "search.md").read_text(encoding="utf-8")


def test_the_comparison_becomes_a_table() -> None:
    def check(name: str, value: float | None, passed: bool = True, detail: str = "") -> dict:
        return {"name": name, "value": value, "bound": 1.0, "detail": detail, "passed": passed}

    checks = [
        check("neighbors at the start", 0),
        check("list length", 0),
        check("forces, max", 1e-13),
        check("rows that differ in print", 2, detail="11 rows"),
        check("mixed: forces, max", 4e-5, passed=False),
        check("mixed: list length", 1, passed=False),
    ]
    scenes = [{"name": "melt", "checks": checks}, {"name": "slab", "checks": [check("runs", None, False, "no kernel")]}]
    melt, fast, *broken = comparison.rows({"scenes": scenes})
    assert (melt.force_error, melt.rows, melt.neighbors, melt.outside) == (1e-13, "9 of 11", "equal", [])
    assert (fast.precision, fast.rows, fast.neighbors) == ("mixed", "-", "differ")
    assert fast.outside == ["forces, max", "list length"]
    assert len(broken) == len(comparison.PRECISIONS) and all(row.outside and row.neighbors == "-" for row in broken)


def test_the_summary_tells_everything(tmp_path: Path) -> None:
    outcomes = [
        Outcome("tests", "physics on cuda", PASSED, "", 12, 0, 1, 3.25, "tests/physics.log"),
        Outcome("sanitizer", "all", SKIPPED, "no compute-sanitizer"),
    ]
    row = comparison.Row("melt", "mixed", 3e-6, "-", "equal", [])
    assert summary.overall([]) == SKIPPED and summary.overall([replace(outcomes[0], skipped=0)]) == PASSED
    assert summary.overall(outcomes[:1]) == SKIPPED, "one of its tests was skipped"
    assert summary.overall(outcomes) == SKIPPED and summary.STATUS[SKIPPED] not in (0, 1, 2)
    summary.write(tmp_path, {"card": "NVIDIA H100"}, outcomes, [row])
    page, data = (tmp_path / "summary.md").read_text(), json.loads((tmp_path / "summary.json").read_text())
    for words in (
        "- card: NVIDIA H100",
        "| physics on cuda | passed | 12 | 0 | 1 | 3.2 |  |",
        "| all | **skipped** | 0 | 0 | 0 | 0.0 | no compute-sanitizer |",
        "| melt | mixed | 3.0e-06 | - | equal | none |",
    ):
        assert words in page
    assert (data["verdict"], data["outcomes"][0]["passed"], data["validation"][0]["neighbors"]) == (
        SKIPPED,
        12,
        "equal",
    )
    failed = [*outcomes, Outcome("tests", "cli", FAILED, "a\ntest | another")]
    assert summary.overall(failed) == FAILED
    assert "- failed: tests, cli" in summary.page({}, failed, []) and "| a test / another |" in summary.page(
        {}, failed, []
    )


def test_what_runs_there_needs_the_standard_library_alone(tmp_path: Path) -> None:
    """Without site-packages it still tells what is missing."""
    call = [sys.executable, "-S", "-m", "validation.bundle", "--results", str(tmp_path)]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "make gpu-bundle" in done.stderr
    assert subprocess.run([*call, "nonsense"], cwd=ROOT, capture_output=True, check=False).returncode == 2


def test_what_is_gathered() -> None:
    sources = [str(path) for path in (ROOT / "validation").glob("*.py") if not make.LEFT_OUT.search(str(path))]
    names = {Path(source).name for source in sources}
    assert {"__main__.py", "compare.py", "reference.py", "lammps_runner.py"} <= names
    assert not names & {"test_bundle.py", "conftest.py", "trajectories.py"}
    assert make.LEFT_OUT.search(str(ROOT / "validation" / "bundle" / "make.py"))


def test_a_bundle_that_is_too_large_names_its_largest_files(tmp_path: Path) -> None:
    folder, packed = tmp_path / "folder", tmp_path / "folder.tar.xz"
    (folder / "suites").mkdir(parents=True)
    (folder / "suites" / "physics").write_bytes(bytes(5 * 2**20))
    (folder / "run.sh").write_bytes(bytes(10))
    packed.write_bytes(bytes(3 * 2**20))
    assert make.size(packed, folder, 4 * 2**20)[1]
    words, fits = make.size(packed, folder, 2 * 2**20)
    assert not fits and "3.0 MiB, allowed are 2.0" in words and "suites/physics 5.0" in words
