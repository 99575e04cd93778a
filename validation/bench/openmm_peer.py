"""The liquid in OpenMM's CPU platform, a process of its own: ``DATA STEPS THREADS [FORCES]``.

Prints nanoseconds an atom and step of a run, or, where a file for the forces is named, writes those of the start.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from validation.bench.liquid import CUTOFF, TIMESTEP, Atoms

#: Untimed steps: the first ones make the list and start the threads.
_WARMING = 20


def _context(liquid: Atoms, threads: int):
    """The system: sigma is a nanometer, epsilon a kJ/mol, the mass a dalton, so the time unit is a picosecond."""
    import openmm

    system = openmm.System()
    low, high = liquid.bounds.T
    system.setDefaultPeriodicBoxVectors(*np.diag(high - low))
    # OpenMM's own kernel rather than a custom force, which is slower; without charges, switch and tail correction it is
    # the plain truncated potential.
    force = openmm.NonbondedForce()
    force.setNonbondedMethod(openmm.NonbondedForce.CutoffPeriodic)
    force.setCutoffDistance(CUTOFF)
    force.setUseSwitchingFunction(False)
    force.setUseDispersionCorrection(False)
    for _ in range(len(liquid.positions)):
        system.addParticle(1.0)
        force.addParticle(0.0, 1.0, 1.0)
    system.addForce(force)
    platform = openmm.Platform.getPlatformByName("CPU")
    context = openmm.Context(system, openmm.VerletIntegrator(TIMESTEP), platform, {"Threads": str(threads)})
    context.setPositions(liquid.positions - low)
    context.setVelocities(liquid.velocities)
    return context


def main() -> None:
    """Does what the command line says."""
    data, steps, threads, *forces = sys.argv[1:]
    liquid = Atoms.read(Path(data))
    context = _context(liquid, int(threads))
    if forces:
        # Without units: numbers in kJ/mol/nm, which are epsilon/sigma.
        np.save(forces[0], context.getState(getForces=True).getForces(asNumpy=True)._value)
        print(0)
        return
    integrator = context.getIntegrator()
    integrator.step(_WARMING)
    started = time.perf_counter()
    integrator.step(int(steps))
    print((time.perf_counter() - started) * 1e9 / (int(steps) * len(liquid.positions)))


if __name__ == "__main__":
    main()
