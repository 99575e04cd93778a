"""The tables as they are measured: every row of every round, read and written as they are."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

#: A line of a table, cells by column.
Row = dict[str, str]

BENCH, OPENMM = "bench.csv", "openmm.csv"

#: Figures of other programs that were measured apart from this run.
PEERS = Path(__file__).resolve().parent.parent / "peers.csv"


def read(path: Path) -> list[Row]:
    """The rows of a table; none where there is no file."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write(path: Path, rows: Sequence[Row]) -> None:
    """Writes rows under the columns of the first."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else [], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def number(row: Row, column: str) -> float | None:
    """A cell as a number; none where it is empty."""
    return float(row[column]) if row.get(column) else None


@dataclass(frozen=True)
class Spread:
    """Median, least and most."""

    median: float
    least: float
    most: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        return cls(median(values), min(values), max(values))


@dataclass(frozen=True)
class Group:
    """All rows of one program, scene, size and precision, in the order of the rounds."""

    rows: tuple[Row, ...]

    @property
    def first(self) -> Row:
        return self.rows[0]

    @property
    def atoms(self) -> int:
        return int(self.first["atoms"])

    @property
    def precision(self) -> str:
        return self.first["precision"]

    def values(self, column: str) -> list[float]:
        """The numbers of a column, empty cells left out."""
        return [value for row in self.rows if (value := number(row, column)) is not None]

    def mean(self, column: str) -> float | None:
        """The mean of a column; none where it is empty."""
        values = self.values(column)
        return sum(values) / len(values) if values else None

    def most(self, column: str) -> float | None:
        """The largest number of a column; none where it is empty."""
        return max(self.values(column), default=None)

    def total(self, column: str) -> int | None:
        """The sum of a column; none where it is empty."""
        values = self.values(column)
        return round(sum(values)) if values else None

    def speed(self, column: str = "matom_steps_per_s") -> Spread:
        """Over the rounds: a row may hold one, or the spread of several."""
        middle = self.values(column)
        low, high = (self.values(f"{column}_{end}") or middle for end in ("least", "most"))
        return Spread(median(middle), min(low), max(high))

    def drift(self) -> tuple[float, float] | None:
        """Drift of the energy, epsilon per atom and tau, and its standard error: means over the rows that have one.

        Rows of several calls may be one trajectory, so that the error of one row stands for all.
        """
        slopes, errors = self.values("drift"), self.values("drift_error")
        if not slopes:
            return None
        return sum(slopes) / len(slopes), sum(errors) / len(errors)


def groups(rows: Iterable[Row], *, scene: str | None = None) -> list[Group]:
    """Rows that belong together, by number of atoms, in the order in which precisions came."""
    found: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if scene is None or row.get("scene") == scene:
            found.setdefault((row.get("scene", ""), row["atoms"], row["precision"]), []).append(row)
    return sorted((Group(tuple(same)) for same in found.values()), key=lambda group: group.atoms)


def ratio(above: Group, below: Group, column: str = "matom_steps_per_s") -> Spread:
    """Round by round where both have as many rows, else of the medians."""
    one, other = above.values(column), below.values(column)
    if len(one) != len(other):
        one, other = [median(one)], [median(other)]
    return Spread.of([a / b for a, b in zip(one, other, strict=True)])
