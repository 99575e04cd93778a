"""Thermo tables and end-of-run statistics of a log file in LAMMPS's format, as printed."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

_STATISTICS = {
    "pairs": re.compile(r"^Total # of neighbors = (\d+)"),
    "per_atom": re.compile(r"^Ave neighs/atom = (\S+)"),
    "builds": re.compile(r"^Neighbor list builds = (\d+)"),
    "dangerous": re.compile(r"^Dangerous builds = (\d+)"),
}


@dataclass
class Run:
    """One run of a log: column names, rows as printed, and the statistics below them."""

    columns: list[str]
    rows: list[list[str]] = field(default_factory=list)
    statistics: dict[str, float] = field(default_factory=dict)

    def column(self, name: str) -> list[float]:
        """The values of one column."""
        index = self.columns.index(name)
        return [float(row[index]) for row in self.rows]


def read_log(path: Path) -> list[Run]:
    """Every run of a log file with a one-line thermo table."""
    runs: list[Run] = []
    in_table = False
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            runs.append(Run(words))
            in_table = True
        elif line.startswith("Loop time of"):
            in_table = False
        elif in_table and words:
            if len(words) != len(runs[-1].columns) or not words[0].lstrip("-").isdigit():
                raise ValueError(f"{path}: a line inside the thermo table is not a row: {line!r}")
            runs[-1].rows.append(words)
        elif runs:
            for name, pattern in _STATISTICS.items():
                if found := pattern.match(line):
                    runs[-1].statistics[name] = float(found.group(1))
    return runs
