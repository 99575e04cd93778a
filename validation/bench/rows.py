"""The results as one long table: a row is one quantity of one contestant."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

#: Values of rows that hold words; the words stand in the column ``unit``.
ABSENT, ISA, CLOCK = "absent", "instruction set", "clock from"

#: The quantity that most sections measure.
COST, COST_UNIT = "cost", "ns/atom-step"


@dataclass(frozen=True)
class Row:
    """One line of ``bench.csv``; columns in this order."""

    section: str
    contestant: str
    atoms: int
    threads: int
    value: str
    unit: str
    median: float = math.nan
    q1: float = math.nan
    q3: float = math.nan
    min: float = math.nan
    rounds: int = 0
    error_rms: float = math.nan
    error_max: float = math.nan
    machine: str = ""
    date: str = ""
    commit: str = ""

    @classmethod
    def of(
        cls, section: str, contestant: str, atoms: int, threads: int, value: str, unit: str, values: Sequence[float]
    ) -> Row:
        """A row with the median and the spread of what the rounds gave."""
        q1, median, q3 = (float(q) for q in np.percentile(values, (25, 50, 75)))
        return cls(section, contestant, atoms, threads, value, unit, median, q1, q3, float(min(values)), len(values))

    @classmethod
    def words(cls, section: str, contestant: str, threads: int, value: str, words: str) -> Row:
        """A row that says something without a number."""
        return cls(section, contestant, 0, threads, value, " ".join(words.split()))


COLUMNS = tuple(field.name for field in fields(Row))

_INTEGERS = {"atoms", "threads", "rounds"}
_WORDS = {"section", "contestant", "value", "unit", "machine", "date", "commit"}


class Rows:
    """Rows in the order in which they were measured."""

    def __init__(self, rows: Iterable[Row] = ()) -> None:
        self.rows = list(rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def where(self, **wanted: object) -> Rows:
        """The rows whose columns have these values."""
        return Rows(row for row in self.rows if all(getattr(row, name) == value for name, value in wanted.items()))

    def first(self, **wanted: object) -> Row | None:
        """The first of these rows, or none."""
        return next(iter(self.where(**wanted)), None)

    def median(self, **wanted: object) -> float:
        """The median of the first of these rows; NaN where there is none."""
        row = self.first(**wanted)
        return row.median if row else math.nan

    def words(self, **wanted: object) -> str:
        """The words of the first of these rows; empty where there is none."""
        row = self.first(**wanted)
        return row.unit if row else ""

    def distinct(self, name: str) -> list:
        """The different values of a column, in order of appearance."""
        return list(dict.fromkeys(getattr(row, name) for row in self.rows))

    def stamped(self, machine: str, date: str, commit: str) -> Rows:
        """The same rows with where and when they were measured."""
        return Rows(replace(row, machine=machine, date=date, commit=commit) for row in self.rows)

    def write(self, path: Path) -> None:
        """Writes the table; cells without a number are empty."""
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(COLUMNS)
            for row in self.rows:
                writer.writerow(_cell(getattr(row, name)) for name in COLUMNS)

    @classmethod
    def read(cls, path: Path) -> Rows:
        """Reads what ``write`` wrote."""
        with path.open(encoding="utf-8", newline="") as file:
            return cls(
                Row(**{name: _value(name, cell) for name, cell in line.items() if name in COLUMNS})
                for line in csv.DictReader(file)
            )


def _cell(value: object) -> object:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return value


def _value(name: str, cell: str) -> object:
    if name in _WORDS:
        return cell
    if name in _INTEGERS:
        return int(cell)
    return float(cell) if cell else math.nan
