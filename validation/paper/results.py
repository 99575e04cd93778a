"""The CSV files of ``octant paper`` in one folder, and times with their spread."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from validation.paper.layout import LAYOUTS, Row, Unfit, whole

#: Files that ``octant paper`` writes, without ``.csv``.
NAMES = tuple(LAYOUTS)


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

    def alike(self, other: Time) -> bool:
        """Whether rounds of the two overlap: noise alone can have made the difference of their medians."""
        return not self.beats(other) and not other.beats(self)

    def gain(self, other: Time) -> float:
        """Percentage by which this is faster than the other: 100 where that takes twice as long."""
        return 100 * (other.median / self.median - 1)

    def over(self, other: Time) -> Time:
        """This as a multiple of the other, with the least and the most that the rounds allow."""
        return Time(self.median / other.median, self.least / other.most, self.most / other.least)


@dataclass(frozen=True)
class Results:
    """What one run has measured."""

    folder: Path
    tables: dict[str, list[Row]]
    #: What was left out, a sentence for each file that was cut off.
    cut: tuple[str, ...] = ()

    @classmethod
    def read(cls, folder: Path) -> Results:
        """All files of a folder, of those that were cut off what is whole. FileNotFoundError where one is missing, Unfit where
        nothing of one is whole or it has a measurement twice."""
        tables, cut = {}, []
        for name in NAMES:
            path = folder / f"{name}.csv"
            try:
                tables[name], left_out = whole(LAYOUTS[name], read(path))
            except Unfit as error:
                raise Unfit(f"{path}: {error}") from error
            cut += [f"`{path.name}` was cut off: {left_out}."] if left_out else []
        return cls(folder, tables, tuple(cut))

    def rows(self, name: str, **wanted: object) -> list[Row]:
        """Rows of a table whose cells are those wanted, numbers by value."""
        return where(self.tables[name], **wanted)

    @property
    def engine(self) -> str:
        """``cuda, NVIDIA H100, mixed precision``; the stability is measured in double precision."""
        return place(self.tables["figure5"])

    @property
    def sizes(self) -> list[int]:
        """Numbers of particles of figure 5."""
        return sorted({int(row["particles"]) for row in self.tables["figure5"]})


def read(path: Path) -> list[Row]:
    """Rows of a file, cells by column; a last row without all its cells is none."""
    with path.open(encoding="utf-8", newline="") as file:
        return [row for row in csv.DictReader(file) if None not in row.values()]


def where(rows: Iterable[Row], **wanted: object) -> list[Row]:
    """Rows whose cells are those wanted; a number is compared as a number."""

    def fits(cell: str, value: object) -> bool:
        return float(cell) == value if isinstance(value, (int, float)) else cell == value

    return [row for row in rows if all(fits(row[name], value) for name, value in wanted.items())]


def one(rows: Sequence[Row], **wanted: object) -> Row:
    """The only such row."""
    (row,) = where(rows, **wanted)
    return row


def by_radix(rows: Iterable[Row]) -> list[tuple[Row, Row]]:
    """Rows of a radix sort with cells in the engine's usual order, each with that of the counting sort in the same order."""
    rows = list(rows)
    found = []
    for row in where(rows, sort="radix"):
        if row["order"] != "zorder":
            same = {name: row[name] for name in ("method", "edge", "order", "particles")}
            found.append((row, one(rows, sort="counting", **same)))
    return found


def place(rows: Sequence[Row]) -> str:
    """Engine, device and precision of a table."""
    return f"{rows[0]['backend']}, {rows[0]['device']}, {rows[0]['precision']} precision"


def shapes(rows: Sequence[Row]) -> str:
    """What is to be known of the kernels behind a table of a GPU: a shape that suits one search need not suit another."""
    if rows[0]["backend"] != "cuda":
        return ""
    if all(row.get("group") and row.get("slices") for row in rows):
        return "Each search ran with the fastest of the kernel's shapes tried (columns `group` and `slices` of the file). "
    return (
        "All searches ran with the kernel's shape that was tuned for the trimmed search of that size; sizes below "
        "65 000 particles are therefore not a fair comparison. "
    )
