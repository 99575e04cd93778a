"""The CSV files of ``octant paper`` in one folder, and times with their spread."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

Row = dict[str, str]

#: Files that ``octant paper`` writes, without ``.csv``.
NAMES = ("table1", "later", "stability", "figure4", "orders", "distributions", "figure5")


@dataclass(frozen=True)
class Time:
    """Median, least and most over the rounds."""

    median: float
    least: float
    most: float

    @classmethod
    def of(cls, row: Row, column: str) -> Time:
        """A column that has two others beside it, ``_least`` and ``_most``."""
        return cls(*(float(row[column + end]) for end in ("", "_least", "_most")))

    def beats(self, other: Time) -> bool:
        """Whether every round was shorter than any of the other's."""
        return self.most < other.least

    def gain(self, other: Time) -> float:
        """Percentage by which this is faster than the other: 100 where that takes twice as long."""
        return 100 * (other.median / self.median - 1)


@dataclass(frozen=True)
class Results:
    """What one run has measured."""

    folder: Path
    tables: dict[str, list[Row]]

    @classmethod
    def read(cls, folder: Path) -> Results:
        """All files of a folder; FileNotFoundError where one is missing."""
        return cls(folder, {name: read(folder / f"{name}.csv") for name in NAMES})

    def rows(self, name: str, **wanted: object) -> list[Row]:
        """Rows of a table whose cells are those wanted, numbers by value."""
        return where(self.tables[name], **wanted)

    @property
    def engine(self) -> str:
        """``cuda, NVIDIA H100, mixed precision``; the stability is measured in double precision."""
        return place(self.tables["figure5"])

    @property
    def sizes(self) -> list[int]:
        """Numbers of particles of figure 5 that every search but that of all pairs has: a run may have been cut off."""
        searches: dict[int, set[str]] = {}
        for row in self.tables["figure5"]:
            if row["method"] != "brute":
                searches.setdefault(int(row["particles"]), set()).add(row["search"])
        most = max(map(len, searches.values()))
        return sorted(size for size, found in searches.items() if len(found) == most)


def read(path: Path) -> list[Row]:
    """Rows of a file, cells by column."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def where(rows: Iterable[Row], **wanted: object) -> list[Row]:
    """Rows whose cells are those wanted; a number is compared as a number."""

    def fits(cell: str, value: object) -> bool:
        return float(cell) == value if isinstance(value, (int, float)) else cell == value

    return [row for row in rows if all(fits(row[name], value) for name, value in wanted.items())]


def one(rows: Sequence[Row], **wanted: object) -> Row:
    """The only such row."""
    (row,) = where(rows, **wanted)
    return row


def place(rows: Sequence[Row]) -> str:
    """Engine, device and precision of a table."""
    return f"{rows[0]['backend']}, {rows[0]['device']}, {rows[0]['precision']} precision"
