"""Contestants in turns."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any


class Absent(RuntimeError):
    """A contestant that cannot be measured here; the message says why."""


@dataclass(frozen=True)
class Sample:
    """One timed run."""

    #: Nanoseconds of the program's own loop time an atom and step.
    cost: float
    #: The report of ``--json``; empty for other programs.
    report: dict[str, Any] = field(default_factory=dict)


@dataclass
class Turns:
    """What the rounds gave, by contestant: samples, or why there are none."""

    samples: dict[Hashable, list[Sample]] = field(default_factory=dict)
    absent: dict[Hashable, str] = field(default_factory=dict)

    def costs(self, key: Hashable) -> list[float]:
        """The cost in each round."""
        return [sample.cost for sample in self.samples.get(key, [])]

    def ratios(self, above: Hashable, below: Hashable) -> list[float]:
        """Cost over cost, round by round: what slows a whole round cancels."""
        return [a / b for a, b in zip(self.costs(above), self.costs(below), strict=False)]


def in_turns(contestants: Mapping[Hashable, Callable[[], Sample]], rounds: int, title: str) -> Turns:
    """Runs every contestant once a round, each round from another one on. One that is absent does not come again."""
    turns = Turns()
    keys = list(contestants)
    started = time.monotonic()
    for index in range(rounds):
        first = index % len(keys)
        for key in keys[first:] + keys[:first]:
            if key in turns.absent:
                continue
            try:
                turns.samples.setdefault(key, []).append(contestants[key]())
            except Absent as reason:
                turns.absent[key] = str(reason)
                turns.samples.pop(key, None)
        say(f"{title}: round {index + 1} of {rounds}, {time.monotonic() - started:.0f} s")
    return turns


def say(line: str) -> None:
    """Progress; the table alone goes to standard output."""
    print(line, file=sys.stderr, flush=True)
