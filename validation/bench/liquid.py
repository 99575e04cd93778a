"""The liquid that everything is measured on: melted once a size by octant in double precision, kept as a data file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from validation.bench.plan import Plan, atoms
from validation.bench.rounds import say
from validation.octant_runner import ROOT, run_octant
from validation.scripts import Script

CUTOFF = 2.5
TIMESTEP = 0.005

#: Density and temperature of the crystal that melts, as in ``validation/scenes/benchmark.in``.
DENSITY = 0.8442
TEMPERATURE = 1.44

#: Pair forces and list policy of the benchmark that molecular-dynamics programs are compared on.
PAIR = ("pair_style lj/cut 2.5", "pair_coeff * * 1.0 1.0 2.5")
LIST = ("neighbor 0.3 bin", "neigh_modify delay 0 every 20 check no")
MOTION = ("fix motion all nve",)


def script(
    data: Path,
    steps: int,
    *,
    head: tuple[str, ...] = (),
    pair: tuple[str, ...] = PAIR,
    neighbor: tuple[str, ...] = LIST,
    motion: tuple[str, ...] = MOTION,
    output: tuple[str, ...] = (),
) -> Script:
    """A run that starts from a data file; each part can be exchanged."""
    start = ("units lj", "atom_style atomic", *head, f"read_data {data}")
    return Script((*start, *pair, *neighbor, f"timestep {TIMESTEP}", *motion, *output, f"run {steps}"))


@dataclass(frozen=True)
class Atoms:
    """A data file as arrays, in the order of the ids."""

    #: Low and high side of the box along x, y, z, shape (3, 2).
    bounds: NDArray[np.float64]
    types: NDArray[np.int64]
    #: Shape (atoms, 3).
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]

    def moved(self, by: float) -> Atoms:
        """The same liquid in a box that lies elsewhere, its positions rounded to what they can be there."""
        bounds = self.bounds + by
        highest = np.nextafter(bounds[:, 1], bounds[:, 0])
        return replace(self, bounds=bounds, positions=np.clip(self.positions + by, bounds[:, 0], highest))

    def two_types(self) -> Atoms:
        """The same liquid with every other atom of a second type."""
        return replace(self, types=1 + np.arange(len(self.types)) % 2)

    def in_wider_box(self, margin: float) -> Atoms:
        """The same liquid with empty space around it."""
        return replace(self, bounds=self.bounds + np.array([-margin, margin]))

    def write(self, path: Path) -> Path:
        """Writes a data file with every digit, and returns its path."""
        kinds = int(self.types.max())
        lines = ["liquid", "", f"{len(self.types)} atoms", f"{kinds} atom types", ""]
        lines += [f"{low!r} {high!r} {a}lo {a}hi" for (low, high), a in zip(self.bounds.tolist(), "xyz", strict=True)]
        lines += ["", "Masses", "", *(f"{kind} 1" for kind in range(1, kinds + 1)), "", "Atoms # atomic", ""]
        rows = zip(self.types.tolist(), self.positions.tolist(), strict=True)
        lines += [f"{i} {kind} {x!r} {y!r} {z!r}" for i, (kind, (x, y, z)) in enumerate(rows, 1)]
        lines += ["", "Velocities", ""]
        lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(self.velocities.tolist(), 1)]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path

    @classmethod
    def read(cls, path: Path) -> Atoms:
        """Reads a data file as ``write_data`` and ``write`` make them."""
        lines = path.read_text(encoding="utf-8").splitlines()
        count = next(int(line.split()[0]) for line in lines if line.endswith(" atoms"))
        sides = [next(line.split()[:2] for line in lines if line.endswith(f"{a}lo {a}hi")) for a in "xyz"]
        body = lines.index("Atoms # atomic") + 2
        table = np.loadtxt(lines[body : body + count], usecols=range(5), ndmin=2)
        body = lines.index("Velocities") + 2
        speeds = np.loadtxt(lines[body : body + count], ndmin=2)
        table, speeds = table[np.argsort(table[:, 0])], speeds[np.argsort(speeds[:, 0])]
        return cls(np.array(sides, dtype=np.float64), table[:, 1].astype(np.int64), table[:, 2:5], speeds[:, 1:4])


class Liquids:
    """Melted liquids in a folder, each made when it is first asked for."""

    def __init__(self, folder: Path, plan: Plan) -> None:
        self.folder, self.plan = folder, plan
        folder.mkdir(parents=True, exist_ok=True)

    def data(self, size: int) -> Path:
        """The data file of a size."""
        path = self.folder / f"melted-{size}-{self.plan.melting}.data"
        if not path.exists():
            say(f"melting {atoms(size)} atoms")
            unfinished = path.with_suffix(".part")
            scene = Script.read(ROOT / "validation" / "scenes" / "benchmark.in")
            scene.then(f"write_data {unfinished} nocoeff").write(path.with_suffix(".in"))
            variables = {"size": size, "steps": self.plan.melting}
            run_octant(path.with_suffix(".in"), variables, threads=self.plan.threads)
            unfinished.rename(path)
        return path

    def atoms(self, size: int) -> Atoms:
        """The liquid of a size as arrays."""
        return Atoms.read(self.data(size))

    def changed(self, size: int, name: str, liquid: Atoms) -> Path:
        """The data file of a liquid made from that of a size; kept under a name."""
        path = self.folder / f"{name}-{size}-{self.plan.melting}.data"
        return path if path.exists() else liquid.write(path)
