"""Energy and pressure at five states beside the equation of state of Thol et al. 2016 (doi:10.1063/1.4945000), by ``teqp``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import teqp

from validation.truth.fluid import Fluid, mean, run
from validation.truth.known import Known

#: Temperature and density: two liquids, three supercritical fluids (the critical point is at 1.32, 0.31).
STATES = ((0.85, 0.82), (1.0, 0.8), (1.5, 0.85), (2.0, 0.5), (3.0, 0.4))

#: Mean of the Laplacian of U over 3 m in these liquids: the frequencies that a timestep has to follow, squared.
_OMEGA_SQUARED = 400.0


@dataclass(frozen=True)
class Equation:
    """An equation of state for the residual Helmholtz energy."""

    kind: str

    def __call__(self, temperature: float, density: float) -> np.ndarray:
        """Potential energy of an atom and pressure."""
        model = teqp.make_model({"kind": self.kind, "model": {}})
        pure = np.array([1.0])
        energy = temperature * model.get_Ar10(temperature, density, pure)
        return np.array([energy, density * temperature * (1.0 + model.get_Ar01(temperature, density, pure))])


#: The judge, and J. Kolafa and I. Nezbeda 1994 (doi:10.1016/0378-3812(94)80001-4), fitted to other simulations. What the two
#: differ by is how well either is known.
THOL, KOLAFA = Equation("LJ126_TholJPCRD2016"), Equation("LJ126_KolafaNezbeda1994")

#: How far U and P of N atoms are below those of many, times N. Measured with lj/smooth/linear 2.5 at T 1.5 and density 0.85, densest
#: of the states: 256 atoms have U -3.8054 +- 0.0008 and P 5.9239 +- 0.0038, 864 have -3.8025 +- 0.0009 and 5.9407 +- 0.0047.
_FINITE = np.array([1.1, 6.2])

#: What the tail corrections of U and P miss as they take g(r) for 1: at most, with g(r) of 1372 atoms measured from a cutoff of 4 up
#: to half of the box, where it differs from 1 by up to 0.03 (T 0.85, density 0.82; less at higher temperatures).
_BEYOND = np.array([9e-5, 1.4e-4])

_REASON = (
    "4 standard errors, what the equations of Thol et al. and of Kolafa and Nezbeda differ by, the timestep's shift of the "
    f"distribution, what N atoms are off ({_FINITE[0]:g}/N in U, {_FINITE[1]:g}/N in P, measured between 256 and 864 atoms) and what "
    f"tail corrections miss ({_BEYOND[0]:g} and {_BEYOND[1]:g}, from g(r) beyond the cutoff)"
)


def checks(*, long: bool, precision: str) -> Iterator[Known]:
    """Energy and pressure at each state; the long form has a longer cutoff, more atoms and 12 times the time."""
    for temperature, density in STATES:
        cells, cutoff, time = (6, 5.0, 200.0) if long else (5, 4.0, 16.0)
        fluid = Fluid(temperature, density, pair=f"lj/cut {cutoff}", tail=True, cells=cells, timestep=0.002 if long else 0.004)
        series = run(fluid, time, 0.04, settle=10.0 if long else 4.0, precision=precision)
        expected, other = THOL(temperature, density), KOLAFA(temperature, density)
        # Velocity Verlet at this temperature of the velocities has positions hotter by (omega dt)^2 / 4.
        hotter = THOL(temperature * (1.0 + _OMEGA_SQUARED * fluid.timestep**2 / 4.0), density)
        # Without the momentum of the whole, the kinetic pressure is that of N - 1 atoms.
        found = (series.potential / fluid.atoms, series.pressure + density * temperature / fluid.atoms)
        for k, what in enumerate(("U", "P")):
            value, error = mean(found[k])
            left = _FINITE[k] / fluid.atoms + _BEYOND[k]
            known = abs(expected[k] - other[k]) + left + abs(hotter[k] - expected[k])
            name = f"Lennard-Jones equation of state (Thol et al. 2016), T {temperature:g}, density {density:g}"
            words = f"{what} {value:.4f} +- {error:.4f}, equation {expected[k]:.4f}: difference"
            yield Known(name, float(abs(value - expected[k])), float(4.0 * error + known), words, _REASON)
