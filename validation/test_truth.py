"""Short forms of what is known of the Lennard-Jones fluid without octant."""

from __future__ import annotations

import numpy as np
import pytest

from validation.truth import ensembles, states
from validation.truth.fluid import mean


@pytest.mark.parametrize("known", [states.checks, ensembles.checks], ids=["equation of state", "ensembles"])
def test_the_fluid_is_as_it_is_known(known) -> None:
    checks = list(known(long=False, precision="mixed"))
    assert len(checks) >= 10
    assert [check for check in checks if not check.passed] == []


def test_equations_give_published_values() -> None:
    # NIST SRD 173, Monte Carlo at T 0.85, density 0.776 (doi:10.18434/T4M88Q): U -5.5121, P 0.0068.
    for equation in (states.THOL, states.KOLAFA):
        energy, pressure = equation(0.85, 0.776)
        assert abs(energy + 5.5121) < 3e-3 and abs(pressure - 0.0068) < 2e-2
    # A dilute gas: the second virial coefficient, 2 pi times the integral of (1 - exp(-U / T)) r^2.
    r = np.linspace(0.3, 60.0, 600_000)
    potential = 4.0 * (r**-12.0 - r**-6.0)
    virial = 2.0 * np.pi * (np.trapezoid((1.0 - np.exp(-potential / 2.0)) * r**2, r) + 0.3**3 / 3.0)
    assert abs((states.THOL(2.0, 1e-4)[1] / 2e-4 - 1.0) / 1e-4 / virial - 1.0) < 0.01


def test_errors_are_those_of_means_of_blocks() -> None:
    noise = np.random.default_rng(4711)
    value, error = mean(noise.normal(3.0, 2.0, 20_000))
    # Independent numbers: 2 / sqrt(20 000), known to 1 / sqrt(40) by 20 blocks.
    assert abs(error / (2.0 / np.sqrt(20_000)) - 1.0) < 4.0 / np.sqrt(40)
    assert abs(value - 3.0) < 4.0 * error
