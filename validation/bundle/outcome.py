"""What became of one suite, sanitizer run or comparison."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

PASSED, FAILED, SKIPPED = "passed", "failed", "skipped"


@dataclass(frozen=True)
class Outcome:
    """One line of the summary. Nothing that was skipped counts as passed."""

    #: Part of the run: tests, sanitizer, validation, bench, paper, engine.
    part: str
    name: str
    #: PASSED, FAILED or SKIPPED.
    verdict: str
    #: Why, where it did not pass; otherwise what there is to say.
    detail: str = ""
    #: Tests of a suite, or comparisons.
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    seconds: float = 0.0
    #: Log in the folder of results.
    log: str = ""

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True)
class Done:
    """A process that has ended: exit status, or None where its time was up; its output, which is also in the log."""

    status: int | None
    output: str
    seconds: float


def call(words: Sequence[str | Path], log: Path, environment: Mapping[str, str], limit: float, folder: Path) -> Done:
    """Runs a process in a folder, output and errors into a log; after ``limit`` seconds it and its own are ended."""
    started = time.monotonic()
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("wb") as file:
        process = subprocess.Popen(
            [str(word) for word in words],
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            env=dict(environment),
            cwd=folder,
            start_new_session=True,
        )
        try:
            status: int | None = process.wait(limit)
        except BaseException as stopped:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            status = None
            if not isinstance(stopped, subprocess.TimeoutExpired):
                raise
    return Done(status, log.read_text(encoding="utf-8", errors="replace"), time.monotonic() - started)
