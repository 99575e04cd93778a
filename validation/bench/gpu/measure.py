"""Runs ``octant bench`` and OpenMM in turns and keeps every row."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from validation.bench.gpu import tables
from validation.bench.gpu.plan import OCTANT, PLAIN, SCENES, Plan
from validation.bench.gpu.worker import Worker
from validation.bench.rounds import Absent, say
from validation.octant_runner import find_binary


@dataclass
class _Run:
    """What there is so far; written after every call, so that a run that is cut off leaves it."""

    plan: Plan
    results: Path
    stamp: dict[str, str]
    started: float = field(default_factory=time.monotonic)
    bench: list[tables.Row] = field(default_factory=list)
    openmm: list[tables.Row] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    #: Why OpenMM is not there.
    absent: str = ""

    def left(self) -> float:
        """Seconds until the time is up."""
        return self.plan.limit - (time.monotonic() - self.started)

    def octant(self, atoms: int, scene: str, rounds: int, turn: int) -> list[tables.Row]:
        """Rows of one call."""
        with tempfile.TemporaryDirectory(prefix="bench-") as folder:
            path = Path(folder) / "bench.csv"
            words = ["--backend", self.plan.backend, "--sizes", str(atoms), "--scene", scene, "--rounds", str(rounds)]
            words += ["--precision", ",".join(OCTANT), "--csv", str(path), *self.plan.words]
            try:
                done = subprocess.run(
                    [find_binary(), "bench", *words],
                    stdout=sys.stderr,
                    stderr=subprocess.PIPE,
                    text=True,
                    cwd=folder,
                    timeout=max(self.left(), 1.0),
                    check=False,
                )
                said = done.stderr.strip() if done.returncode else ""
            except subprocess.TimeoutExpired:
                said = "the time was up"
            fresh = [row | {"turn": str(turn)} | self.stamp for row in tables.read(path)]
        if said:
            self.failures.append(f"{scene}, {atoms} atoms: {said}")
            say(self.failures[-1])
        self.bench += fresh
        if fresh:
            tables.write(self.results / tables.BENCH, self.bench)
        return fresh

    def in_turns(self, atoms: int) -> None:
        """Rounds of octant with OpenMM's between them, its contexts kept."""
        worker: Worker | None = None
        try:
            for turn in range(self.plan.rounds):
                fresh = self.octant(atoms, PLAIN, 1, turn)
                if not fresh:
                    break
                if self.absent:
                    continue
                try:
                    if worker is None:
                        worker = Worker(fresh[0]["cells"], self.plan)
                    self.openmm += [
                        row | {"turn": str(turn)} | self.stamp for row in worker.legs(max(self.left(), 1.0))
                    ]
                    tables.write(self.results / tables.OPENMM, self.openmm)
                except Absent as reason:
                    self.absent = str(reason)
                    say(f"OpenMM: {reason}")
        finally:
            if worker:
                worker.close()


def run(plan: Plan, results: Path, stamp: dict[str, str]) -> list[str]:
    """Measures everything, small sizes first; what went wrong, line by line."""
    results.mkdir(parents=True, exist_ok=True)
    # Nothing of an earlier run stays beside what is measured now.
    for name in (tables.BENCH, tables.OPENMM):
        (results / name).unlink(missing_ok=True)
    state = _Run(plan, results, stamp)
    beside = [size for size in plan.sizes if size <= plan.turns]
    compared = max((size for size in plan.sizes if size <= plan.scene_size), default=None)
    cases = [(size, PLAIN) for size in beside]
    cases += [(compared, scene) for scene in SCENES] if compared else []
    cases += [(size, PLAIN) for size in plan.sizes if size > plan.turns]
    for size, scene in cases:
        if state.left() <= 0:
            state.failures.append(f"{scene}, {size} atoms: left out, the time was up")
            continue
        say(f"{scene}, {size} atoms, {state.left():.0f} s left")
        if scene == PLAIN and size in beside:
            state.in_turns(size)
        else:
            state.octant(size, scene, plan.rounds, 0)
        if state.failures and not state.bench:
            # What fails with the fewest atoms fails with more.
            break
    return state.failures
