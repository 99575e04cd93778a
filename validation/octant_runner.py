"""Runs scripts through the ``octant`` binary."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from validation.logs import Run, read_log

ROOT = Path(__file__).resolve().parent.parent


class OctantError(RuntimeError):
    """octant refused a script or stopped; the message is what it printed."""


@dataclass(frozen=True)
class OctantResult:
    """What a run left behind."""

    runs: list[Run]
    #: Log file as octant wrote it.
    log: str
    #: The summary of ``--json``.
    summary: dict[str, Any]
    screen: str


def find_binary() -> Path:
    """The binary to judge: the environment variable OCTANT, or the release build of this checkout."""
    if named := os.environ.get("OCTANT"):
        binary = Path(named).resolve()
    else:
        binary = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "octant"
    if not binary.is_file():
        raise FileNotFoundError(f"no octant binary at {binary}: run `make build` first, or name one in OCTANT")
    return binary


def call(*arguments: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Calls octant; the caller looks at the exit code."""
    return subprocess.run([find_binary(), *arguments], capture_output=True, text=True, cwd=cwd or ROOT, check=False)


def _checked(done: subprocess.CompletedProcess[str], script: Path) -> str:
    if done.returncode != 0:
        raise OctantError(
            f"octant ended with {done.returncode} in {script}:\n{done.stderr.strip() or done.stdout.strip()}"
        )
    return done.stdout


def _variables(variables: Mapping[str, str | int] | None) -> list[str]:
    return [word for name, value in (variables or {}).items() for word in ("-v", f"{name}={value}")]


def run_octant(
    script: Path,
    variables: Mapping[str, str | int] | None = None,
    *,
    threads: int | None = None,
    search: str | None = None,
    precision: str = "double",
    backend: str = "cpu",
    log: Path | None = None,
) -> OctantResult:
    """Runs a script. Raises OctantError with octant's message where it stops."""
    with tempfile.TemporaryDirectory(prefix="octant-") as scratch:
        log = log or Path(scratch) / "log.octant"
        summary = Path(scratch) / "summary.json"
        options: list[str | Path] = ["--backend", backend, "--precision", precision, "--log", log, "--json", summary]
        options += ["--threads", str(threads)] if threads else []
        options += ["--search", search] if search else []
        screen = _checked(call("run", script, *_variables(variables), *options), script)
        return OctantResult(
            runs=read_log(log),
            log=log.read_text(encoding="utf-8"),
            summary=json.loads(summary.read_text(encoding="utf-8")),
            screen=screen,
        )


def count_neighbors(
    script: Path,
    variables: Mapping[str, str | int] | None = None,
    *,
    search: str | None = None,
    backend: str = "cpu",
) -> NDArray[np.int64]:
    """Number of neighbors of every atom in the initial configuration, indexed by id - 1."""
    with tempfile.TemporaryDirectory(prefix="octant-") as scratch:
        counts = Path(scratch) / "counts.txt"
        options: list[str | Path] = ["--backend", backend, "--counts", counts]
        options += ["--search", search] if search else []
        _checked(call("neighbors", script, *_variables(variables), *options), script)
        table = np.loadtxt(counts, dtype=np.int64, ndmin=2)
    by_id = np.zeros(int(table[:, 0].max(initial=0)), dtype=np.int64)
    by_id[table[:, 0] - 1] = table[:, 1]
    return by_id
