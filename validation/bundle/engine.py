"""criterion's benches, CPU and GPU: every time that a bench prints, on a page ``engine/NAME.md`` beside its log."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from validation.bundle.outcome import FAILED, PASSED, SKIPPED, Outcome, call
from validation.markdown import number, table

#: Seconds that a bench may take.
LIMIT = 3600.0

_TIME = re.compile(r"^(.*?)\s+time:\s+\[(\S+) (\S+) (\S+) (\S+) (\S+) (\S+)\]$")
_MICROSECONDS = {"ps": 1e-6, "ns": 1e-3, "µs": 1.0, "ms": 1e3, "s": 1e6}
_UNITS = "Microseconds: criterion's estimate and the interval that holds it at 95 %; cuda stands at what ran on the GPU."
#: What a bench says instead of times of a GPU.
_NO_GPU = re.compile(r"^no .* on a GPU: (.+)$", re.MULTILINE)


@dataclass(frozen=True)
class Measured:
    """A time in microseconds: estimate and the ends of its confidence interval, as criterion has them."""

    group: str
    case: str
    low: float
    time: float
    high: float


def read(output: str) -> list[Measured]:
    """Times in what a bench printed; a long name stands on the line before its time."""
    found, before = [], ""
    for line in output.splitlines():
        if match := _TIME.match(line):
            name, *words = match.groups()
            low, time, high = (
                float(value) * _MICROSECONDS[unit] for value, unit in zip(words[::2], words[1::2], strict=True)
            )
            group, _, case = (name or before).strip().partition("/")
            found.append(Measured(group, case, low, time, high))
        before = line
    return found


def page(name: str, about: str, found: list[Measured]) -> str:
    """Times of groups that have a case in common stand side by side."""
    tables: list[tuple[list[str], list[str]]] = []
    for group in dict.fromkeys(one.group for one in found):
        cases = [one.case for one in found if one.group == group]
        for groups, there in tables:
            if set(cases) & set(there):
                groups.append(group)
                there.extend(case for case in cases if case not in there)
                break
        else:
            tables.append(([group], cases))
    times = {(one.group, one.case): one for one in found}
    lines = [f"# Bench `{name}`", "", about, "", _UNITS, ""]
    for groups, cases in tables:
        lines += table(["", *groups], ([case, *(_cell(times.get((group, case))) for group in groups)] for case in cases))
    return "\n".join(lines)


def _cell(one: Measured | None) -> str:
    if one is None:
        return "-"
    time, low, high = (number(value, 4) for value in (one.time, one.low, one.high))
    return f"{time} ({low} to {high})"


def run(
    root: Path,
    results: Path,
    scratch: Path,
    environment: Mapping[str, str],
    backend: str,
    files: list[str],
    about: Mapping[str, str],
) -> Iterator[Outcome]:
    """Every bench; one that has nothing to say of the GPU under test did not pass."""
    where = f"{about['date'][:10]}, commit {about['commit']}, {about['card']}."
    for file in files:
        name = Path(file).name
        log = Path("engine") / f"{name}.log"
        done = call([root / file, "--bench"], results / log, environment, LIMIT, scratch)
        found = read(done.output)
        (results / "engine" / f"{name}.md").write_text(page(name, where, found), encoding="utf-8")
        verdict, detail = PASSED, ""
        if done.status is None:
            verdict, detail = FAILED, f"did not end within {LIMIT:.0f} s"
        elif done.status != 0 or not found:
            verdict, detail = FAILED, f"exit status {done.status}" if done.status else "no time in it"
        elif backend == "cuda" and (missing := _NO_GPU.search(done.output)):
            verdict, detail = SKIPPED, missing[1]
        yield Outcome("engine", name, verdict, detail, len(found), seconds=done.seconds, log=str(log))
