"""A Lennard-Jones fluid run through ``octant``, and means with error bars of what it prints."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from validation.dumps import Frame, full_precision, read_dump
from validation.octant_runner import run_octant

#: ``cpu`` or ``cuda``, as tests of the Rust side have it.
BACKEND = os.environ.get("OCTANT_TEST_BACKEND") or "cpu"

#: Blocks whose means stand for independent ones.
BLOCKS = 20

_SCRIPT = """
units lj
lattice fcc {density}
region box block 0 {cells} 0 {cells} 0 {cells}
create_box 1 box
create_atoms 1 box
mass 1 1.0
velocity all create {hot} 4711 loop geom
pair_style {pair}
pair_coeff 1 1 1.0 1.0
pair_modify tail {tail}
timestep {timestep}
fix melt all nvt temp {hot} {temperature} 0.2
run {settle}
unfix melt
{fixes}
run {settle}
{dump}
thermo_style custom step temp pe ke etotal press
thermo_modify norm no format float %.17g
thermo {every}
run {steps}
"""


@dataclass(frozen=True)
class Fluid:
    """A state and how it is simulated; lengths, energies and times are Lennard-Jones units."""

    temperature: float
    density: float
    pair: str = "lj/smooth/linear 2.5"
    tail: bool = False
    #: fcc unit cells along each edge.
    cells: int = 5
    timestep: float = 0.002
    #: Fixes after melting; ``{T}`` is the temperature.
    fixes: str = "fix bath all nvt temp {T} {T} 0.2"

    @property
    def atoms(self) -> int:
        """Number of atoms."""
        return 4 * self.cells**3

    @property
    def volume(self) -> float:
        """Volume of the box."""
        return self.atoms / self.density


@dataclass(frozen=True)
class Series:
    """What a run printed, extensive, one value a row; frames if they were asked for."""

    temperature: NDArray[np.float64]
    potential: NDArray[np.float64]
    kinetic: NDArray[np.float64]
    total: NDArray[np.float64]
    pressure: NDArray[np.float64]
    frames: list[Frame]


def run(fluid: Fluid, time: float, every: float, *, settle: float = 10.0, precision: str = "mixed", dump: float = 0.0) -> Series:
    """Melts twice as hot, cools, brings to rest and then records for ``time``, a row each ``every``; ``dump`` is the time
    between frames with positions and velocities.
    """

    def count(span: float) -> int:
        return round(span / fluid.timestep)

    with tempfile.TemporaryDirectory(prefix="truth-") as scratch:
        frames = Path(scratch) / "frames.dump"
        text = _SCRIPT.format(
            density=fluid.density,
            cells=fluid.cells,
            hot=max(3.0, fluid.temperature),
            pair=fluid.pair,
            tail="yes" if fluid.tail else "no",
            timestep=fluid.timestep,
            temperature=fluid.temperature,
            fixes=fluid.fixes.format(T=fluid.temperature),
            settle=count(settle),
            every=count(every),
            steps=count(time),
            dump="\n".join(full_precision(count(dump), frames, "id x y z vx vy vz")) if dump else "",
        )
        script = Path(scratch) / "fluid.in"
        script.write_text(text, encoding="utf-8")
        last = run_octant(script, backend=BACKEND, precision=precision).runs[-1]
        # The first row is of the state before.
        columns = [np.array(last.column(name))[1:] for name in ("Temp", "PotEng", "KinEng", "TotEng", "Press")]
        return Series(*columns, frames=read_dump(frames)[1:] if dump else [])


def mean(series: NDArray[np.float64]) -> tuple[float, float]:
    """Mean and its standard error from means of blocks."""
    blocks = series[: len(series) // BLOCKS * BLOCKS].reshape(BLOCKS, -1).mean(axis=1)
    return float(series.mean()), float(blocks.std(ddof=1) / np.sqrt(BLOCKS))
