"""Velocities, energies and steps of an isothermal or isolated fluid as statistical mechanics has them: tests of
``physical_validation`` (P. T. Merz and M. R. Shirts 2018, doi:10.1371/journal.pone.0202764).
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.stats import norm

from validation.truth.fluid import Fluid, Series, run
from validation.truth.known import Known

# A package that it rests on says on import what it would like to have beside it.
with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
    import physical_validation as pv
    from physical_validation.data import EnsembleData, ObservableData, SimulationData, SystemData, TrajectoryData, UnitData

#: Thermostats, and the degrees of freedom that each leaves out: random forces move the whole, a chain does not.
BATHS = {
    "fix nvt": ("fix bath all nvt temp {T} {T} 0.2", 3),
    "fix langevin": ("fix bath all langevin {T} {T} 0.5 87287\nfix move all nve", 0),
}

#: Energies have no step at the cutoff, so that those that are printed are those that forces belong to.
FLUID = Fluid(temperature=1.0, density=0.8, cells=4)

#: Time between rows, which is long enough for kinetic energies to forget most of what they were.
_EVERY = 0.2

#: Standard deviations; of the normal distribution 1 in 16 000 is farther off.
_MOST = 4.0

#: Seed of the package's resampling.
_SEED = 4711

_REASON = "4 standard deviations, 1 in 16 000; the package estimates them from what is independent in the series"
_LARGEST = "so many standard deviations that the largest of them is farther off 1 time in 16 000"
_PROBABILITY = "a probability of 6e-5, as 4 standard deviations have it"
_UNLIKELY = 6e-5
_ORDER = "4 standard errors of a ratio of two fluctuations, and 2 % for the next order of the timestep"


def checks(*, long: bool, precision: str) -> Iterator[Known]:
    """All of them; the long form has ten times the time."""
    time = 2000.0 if long else 160.0
    for bath, (fixes, lost) in BATHS.items():
        fluid = replace(FLUID, fixes=fixes)
        cold = run(fluid, time, _EVERY, precision=precision, dump=time / 200.0)
        yield from _velocities(bath, _data(fluid, cold, lost))
        warm = _warmer(fluid)
        hot = run(warm, time, _EVERY, precision=precision)
        yield from _energies(bath, _data(fluid, cold, lost), _data(warm, hot, lost))
    yield from _steps(precision, 20.0 if long else 8.0)


def _warmer(fluid: Fluid) -> Fluid:
    """The temperature at which the total energy lies 2.5 of its standard deviations higher, with a heat capacity of 2.4 an atom:
    far enough for a slope, near enough for distributions that overlap.
    """
    return replace(fluid, temperature=round(fluid.temperature * (1.0 + 2.5 / np.sqrt(2.4 * fluid.atoms)), 3))


def _quiet(test, *arguments, **options):
    """What a test of the package returns, without what it prints."""
    with contextlib.redirect_stdout(io.StringIO()):
        return test(*arguments, **options)


def _velocities(bath: str, data: SimulationData) -> Iterator[Known]:
    """Kinetic energies: mean and width of the whole, and of the atoms' directions and parts."""
    options = {"verbosity": 0, "bootstrap_seed": _SEED}
    mean, width = _quiet(pv.kinetic_energy.distribution, data, **options)
    name = f"{bath}: Maxwell's kinetic energies"
    yield Known(name, abs(float(mean)), _MOST, "standard deviations of the mean", _REASON)
    yield Known(name, abs(float(width)), _MOST, "standard deviations of the width", _REASON)
    probability = _quiet(pv.kinetic_energy.distribution, data, strict=True, verbosity=0)
    # Stated so that small is good, as everywhere, and so that the distance to the bound shows.
    words = "-log10 p of Kolmogorov and Smirnov's test of the distribution"
    yield Known(name, -float(np.log10(max(float(probability), 1e-300))), -float(np.log10(_UNLIKELY)), words, _PROBABILITY)
    groups = {"random_divisions": 3, "random_groups": 2, "random_division_seed": _SEED}
    parts = _quiet(pv.kinetic_energy.equipartition, data, **groups, **options)
    off = np.abs(np.array(parts, dtype=float))
    off = off[np.isfinite(off)]
    # The largest of so many is farther off by chance than one of them.
    most = float(norm.isf(norm.sf(_MOST) / off.size))
    words = f"standard deviations, the largest of {off.size} means and widths of halves of the atoms drawn at random"
    yield Known(f"{bath}: equipartition", float(off.max()), most, words, _LARGEST)


def _energies(bath: str, cold: SimulationData, warm: SimulationData) -> Iterator[Known]:
    """Distributions of the energy at two temperatures differ by the factor of Boltzmann."""
    temperatures = f"{cold.ensemble.temperature:g} and {warm.ensemble.temperature:g}"
    for total, what in ((False, "potential"), (True, "total")):
        (off,) = _quiet(pv.ensemble.check, cold, warm, total_energy=total, verbosity=0, bootstrap_seed=_SEED)
        words = f"standard deviations of the slope of the {what} energies' ratio"
        yield Known(f"{bath}: energies at T {temperatures} as Boltzmann has them", abs(float(off)), _MOST, words, _REASON)


def _steps(precision: str, time: float) -> Iterator[Known]:
    """Fluctuation of the energy of an isolated fluid, of the square of the timestep.

    In single precision too: at a timestep of 0.001 the total energy of the 256 atoms fluctuates by 2.0e-3 in double and 2.2e-3
    in single, and from row to row it changes by 0.8e-3 and 0.7e-3, so that rounding (1e-7 of a potential energy of 1300, 1.3e-4)
    does not show beside it.
    """
    runs = []
    for timestep in (0.004, 0.002, 0.001):
        fluid = replace(FLUID, timestep=timestep, fixes="fix move all nve")
        runs.append((fluid, run(fluid, time, 0.004, precision=precision)))
    off = _quiet(pv.integrator.convergence, [_data(fluid, series, 3) for fluid, series in runs], verbose=False)
    errors = [_relative_error(series.total) for _, series in runs]
    error = max(np.hypot(a, b) for a, b in pairwise(errors))
    words = f"ratios of fluctuations over those of dt^2, less 1 (standard error {error:.3f})"
    yield Known("fix nve: the energy fluctuates as dt^2", float(off), float(_MOST * error + 0.02), words, _ORDER)


def _relative_error(total: np.ndarray) -> float:
    """Relative standard error of the fluctuation of a series."""
    squares = (total - total.mean()) ** 2
    blocks = squares[: len(squares) // 20 * 20].reshape(20, -1).mean(axis=1)
    return float(0.5 * blocks.std(ddof=1) / np.sqrt(20) / squares.mean())


def _data(fluid: Fluid, series: Series, lost: int) -> SimulationData:
    """A run as the package has it; ``lost`` degrees of freedom are those of the whole."""
    system = SystemData(natoms=fluid.atoms, nconstraints=0, ndof_reduction_tra=lost, ndof_reduction_rot=0)
    system.mass, system.molecule_idx = np.ones(fluid.atoms), np.arange(fluid.atoms)
    system.nconstraints_per_molecule = np.zeros(fluid.atoms)
    data = SimulationData(
        units=UnitData(
            kb=1.0,
            energy_conversion=1.0,
            length_conversion=1.0,
            volume_conversion=1.0,
            temperature_conversion=1.0,
            pressure_conversion=1.0,
            time_conversion=1.0,
        ),
        dt=fluid.timestep,
        system=system,
        ensemble=EnsembleData("NVT", natoms=fluid.atoms, volume=fluid.volume, temperature=fluid.temperature),
        observables=ObservableData(
            kinetic_energy=series.kinetic,
            potential_energy=series.potential,
            total_energy=series.total,
            constant_of_motion=series.total,
        ),
    )
    if series.frames:
        values = np.array([frame.values for frame in series.frames])
        data.trajectory = TrajectoryData(position=values[:, :, 1:4], velocity=values[:, :, 4:7])
    return data
