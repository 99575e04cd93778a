"""Test binaries of ``cargo test``: run one by one, their results counted."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from validation.bundle.device import Device
from validation.bundle.outcome import FAILED, PASSED, SKIPPED, Done, Outcome, call

#: Seconds that a suite may take.
LIMIT = 1200.0

_RESULT = re.compile(r"^test (.+?) \.\.\. (ok|FAILED|ignored)", re.MULTILINE)
_TOTAL = re.compile(r"^test result: \w+\. (\d+) passed; (\d+) failed; (\d+) ignored", re.MULTILINE)
#: Output of one test, as ``--show-output`` prints it.
_BLOCK = re.compile(r"^---- (.+?) stdout ----$(.*?)(?=^---- |^(?:successes|failures):$|\Z)", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Suite:
    """A test binary."""

    name: str
    file: str
    #: Its tests run on every backend, or on the one that OCTANT_TEST_BACKEND names.
    engines: bool


def reasons(output: str) -> dict[str, str]:
    """Tests that passed without having run, and why: they say ``skipped:``."""
    well = {test for test, result in _RESULT.findall(output) if result == "ok"}
    found: dict[str, str] = {}
    for test, text in _BLOCK.findall(output):
        said = [line.strip() for line in text.splitlines() if line.strip().startswith("skipped:")]
        if said and test in well:
            found[test] = said[0].removeprefix("skipped:").strip()
    return found


def verdicts(output: str) -> dict[str, str]:
    """PASSED, FAILED or SKIPPED by the names of the tests that have printed it."""
    words = {"ok": PASSED, "FAILED": FAILED, "ignored": SKIPPED}
    found = {test: words[result] for test, result in _RESULT.findall(output)}
    return found | dict.fromkeys(reasons(output), SKIPPED)


def judge(name: str, done: Done, log: str) -> Outcome:
    """Counts the tests of a suite that has ended. A test that says ``skipped:`` is one that did not run."""
    totals = [tuple(map(int, found)) for found in _TOTAL.findall(done.output)]
    passed, failed, skipped = (sum(column) for column in zip(*totals, strict=True)) if totals else (0, 0, 0)
    left_out = reasons(done.output)
    passed, skipped = passed - len(left_out), skipped + len(left_out)
    verdict, detail = PASSED, "; ".join(dict.fromkeys(left_out.values()))
    if done.status is None:
        verdict, detail = FAILED, f"did not end within {LIMIT:.0f} s"
    elif done.status != 0 or failed or not totals:
        broken = [test for test, result in verdicts(done.output).items() if result == FAILED]
        verdict, detail = FAILED, ", ".join(broken) or f"exit status {done.status}, no test result"
    elif passed == 0:
        verdict = SKIPPED
        detail = detail or "there is no test in it"
    return Outcome("tests", name, verdict, detail, passed, failed, skipped, done.seconds, log)


def run(
    suites: list[Suite],
    root: Path,
    results: Path,
    scratch: Path,
    environment: Mapping[str, str],
    device: Device,
    backend: str,
) -> Iterator[Outcome]:
    """Every suite; those of engines on ``backend``, and where there is no GPU for it on the CPU, which is said."""
    bare = {name: value for name, value in environment.items() if name != "OCTANT_TEST_BACKEND"}
    bare |= {"CARGO_BIN_EXE_octant": str(root / "bin" / "octant"), "OCTANT_TEST_ROOT": str(root)}
    for suite in suites:
        name, here = suite.name, dict(bare)
        if suite.engines:
            engine = backend if device.present or backend == "cpu" else "cpu"
            if engine != backend:
                yield Outcome("tests", f"{suite.name} on {backend}", SKIPPED, device.missing)
            name, here["OCTANT_TEST_BACKEND"] = f"{suite.name} on {engine}", engine
        log = Path("tests") / f"{name.replace(' ', '-')}.log"
        done = call([root / suite.file, "--show-output"], results / log, here, LIMIT, scratch)
        yield judge(name, done, str(log))
