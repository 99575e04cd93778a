"""The liquid in OpenMM's CPU platform, a process of its own: ``DATA STEPS THREADS [FORCES]``.

Prints nanoseconds an atom and step of a run, or, where a file for the forces is named, writes those of the start.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from validation.bench.liquid import CUTOFF, TIMESTEP, Atoms

#: Untimed steps: the first ones make the list and start the threads.
_WARMING = 20


def system(lengths: Sequence[float], count: int):
    """Lennard-Jones particles: sigma is a nanometer, epsilon a kJ/mol, the mass a dalton, hence the time unit a ps."""
    import openmm

    made = openmm.System()
    made.setDefaultPeriodicBoxVectors(*np.diag(lengths))
    # OpenMM's own kernel rather than a custom force, which is slower; without charges, switch and tail correction it is
    # the plain truncated potential.
    force = openmm.NonbondedForce()
    force.setNonbondedMethod(openmm.NonbondedForce.CutoffPeriodic)
    force.setCutoffDistance(CUTOFF)
    force.setUseSwitchingFunction(False)
    force.setUseDispersionCorrection(False)
    for _ in range(count):
        made.addParticle(1.0)
        force.addParticle(0.0, 1.0, 1.0)
    made.addForce(force)
    return made


def context(made, platform: str, properties: Mapping[str, str], positions: NDArray, velocities: NDArray):
    """A system on a platform, with the integrator of the benchmark."""
    import openmm

    found = openmm.Platform.getPlatformByName(platform)
    started = openmm.Context(made, openmm.VerletIntegrator(TIMESTEP), found, dict(properties))
    started.setPositions(positions)
    started.setVelocities(velocities)
    return started


def forces_of(state) -> NDArray[np.float64]:
    """Forces of a state without units: numbers in kJ/mol/nm, which are epsilon/sigma."""
    return state.getForces(asNumpy=True)._value


def _context(liquid: Atoms, threads: int):
    low, high = liquid.bounds.T
    made = system(high - low, len(liquid.positions))
    return context(made, "CPU", {"Threads": str(threads)}, liquid.positions - low, liquid.velocities)


def main() -> None:
    """Does what the command line says."""
    data, steps, threads, *forces = sys.argv[1:]
    liquid = Atoms.read(Path(data))
    run = _context(liquid, int(threads))
    if forces:
        np.save(forces[0], forces_of(run.getState(getForces=True)))
        print(0)
        return
    integrator = run.getIntegrator()
    integrator.step(_WARMING)
    started = time.perf_counter()
    integrator.step(int(steps))
    print((time.perf_counter() - started) * 1e9 / (int(steps) * len(liquid.positions)))


if __name__ == "__main__":
    main()
