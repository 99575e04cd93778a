"""Frames of a LAMMPS text dump as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

#: What a full-precision dump holds; each of the two programs gets the same line.
COLUMNS = "id type x y z vx vy vz fx fy fz"


def full_precision(every: int, path: Path, columns: str = COLUMNS) -> tuple[str, str]:
    """The statements that write every digit of the atoms to a file, in the order of their ids."""
    return f"dump full all custom {every} {path} {columns}", "dump_modify full sort id format float %.17g"


@dataclass(frozen=True)
class Frame:
    """One step of a dump."""

    step: int
    #: Low and high side of the box along x, y, z, shape (3, 2).
    bounds: NDArray[np.float64]
    #: Which axes are periodic, shape (3,).
    periodic: NDArray[np.bool_]
    #: Column names.
    columns: tuple[str, ...]
    #: Values, shape (atoms, columns).
    values: NDArray[np.float64]

    def __getitem__(self, names: str) -> NDArray[np.float64]:
        """One column by its name, or several by their names with spaces between, shape (atoms, names)."""
        wanted = [self.columns.index(name) for name in names.split()]
        return self.values[:, wanted[0]] if len(wanted) == 1 else self.values[:, wanted]

    def only(self, names: str) -> Frame:
        """The frame with some of its columns, their names with spaces between."""
        return Frame(self.step, self.bounds, self.periodic, tuple(names.split()), self[names])

    @property
    def lengths(self) -> NDArray[np.float64]:
        """Box lengths, shape (3,)."""
        return self.bounds[:, 1] - self.bounds[:, 0]

    def displacement(self, other: Frame) -> NDArray[np.float64]:
        """Positions minus those of another frame, nearest image along periodic axes, shape (atoms, 3)."""
        difference = self["x y z"] - other["x y z"]
        images = np.round(difference / self.lengths) * self.lengths
        return difference - np.where(self.periodic, images, 0.0)


def read_dump(path: Path) -> list[Frame]:
    """Every frame of a text dump (``dump atom`` or ``dump custom`` with numbers only)."""
    frames: list[Frame] = []
    with path.open(encoding="utf-8") as lines:
        step = atoms = 0
        for line in lines:
            if line.startswith("ITEM: TIMESTEP"):
                step = int(next(lines))
            elif line.startswith("ITEM: NUMBER OF ATOMS"):
                atoms = int(next(lines))
            elif line.startswith("ITEM: BOX BOUNDS"):
                periodic = np.array([flag[0] == "p" for flag in line.split()[3:6]])
                bounds = np.array([[float(word) for word in next(lines).split()[:2]] for _ in range(3)])
            elif line.startswith("ITEM: ATOMS"):
                columns = tuple(line.split()[2:])
                rows = [next(lines).split() for _ in range(atoms)]
                values = np.array(rows, dtype=np.float64).reshape(atoms, len(columns))
                frames.append(Frame(step, bounds, periodic, columns, values))
    return frames
