"""The programs that are timed, each run a process of its own that reads a melted liquid."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from validation.bench.liquid import script
from validation.bench.rounds import Absent, Sample
from validation.octant_runner import ROOT, find_binary
from validation.scripts import Script


@dataclass(frozen=True)
class Octant:
    """octant in one of its modes; ``isa`` asks for an instruction set."""

    mode: str
    threads: int
    isa: str | None = None

    @property
    def name(self) -> str:
        """What tables call it."""
        return f"octant {self.mode}" + (f" {self.isa}" if self.isa else "")

    def run(self, scene: Script) -> dict:
        """Runs a script and returns the report of ``--json``."""
        with tempfile.TemporaryDirectory(prefix="octant-") as folder:
            path = scene.write(Path(folder) / "scene.in")
            report = Path(folder) / "report.json"
            command = [find_binary(), "run", path, "--backend", "cpu", "--precision", self.mode, "--quiet"]
            command += ["--threads", str(self.threads), "--log", Path(folder) / "log", "--json", report]
            _run(command, {"OCTANT_ISA": self.isa} if self.isa else {})
            answer = json.loads(report.read_text(encoding="utf-8"))
        if self.isa and (taken := answer["settings"].get("isa")) != self.isa:
            raise Absent(
                f"the binary took {taken}" if taken else "the binary does not say which instruction set it took"
            )
        return answer

    def time(self, data: Path, steps: int, scene: Script | None = None) -> Sample:
        """Times a run from a data file: the liquid's, or a script made for that file."""
        report = self.run(scene or script(data, steps))
        return Sample(report["timing"]["loop_s"] * 1e9 / (steps * report["atoms"]), report)

    def forces(self, data: Path) -> NDArray[np.float64]:
        """Forces on the atoms of a data file, in the order of their ids."""
        return _dumped_forces(data, self.run)


@dataclass(frozen=True)
class Lammps:
    """LAMMPS with the styles of its package ``opt`` or ``omp``, or with ``opt`` on several MPI processes."""

    flavor: str
    threads: int

    @property
    def name(self) -> str:
        """What tables call it."""
        return f"LAMMPS {self.flavor}"

    def run(self, scene: Script) -> str:
        """Runs a script and returns the log."""
        # Not found through PATH: the wheel and the MPI library it was built for lie beside this interpreter.
        programs = Path(sys.executable).parent
        for program in ("lmp", "mpirun"):
            if not (programs / program).exists():
                raise Absent(f"there is no {program} beside the Python that runs this")
        omp = self.flavor == "omp"
        start = [programs / "mpirun", "-n", str(self.threads)] if self.flavor == "mpi" else []
        styles = ["-sf", "omp", "-pk", "omp", str(self.threads)] if omp else ["-sf", "opt"]
        with tempfile.TemporaryDirectory(prefix="lammps-") as folder:
            path, log = scene.write(Path(folder) / "scene.in"), Path(folder) / "log"
            command = [*start, programs / "lmp", "-in", path, "-log", log, "-screen", "none", *styles]
            _run(command, {"OMP_NUM_THREADS": str(self.threads if omp else 1)})
            return log.read_text(encoding="utf-8")

    def time(self, data: Path, steps: int) -> Sample:
        """Times a run from a data file."""
        return Sample(loop_cost(self.run(script(data, steps))))

    def forces(self, data: Path) -> NDArray[np.float64]:
        """Forces on the atoms of a data file, in the order of their ids."""
        return _dumped_forces(data, self.run)


@dataclass(frozen=True)
class OpenMM:
    """The CPU platform of OpenMM."""

    threads: int
    name: str = "OpenMM CPU"

    def time(self, data: Path, steps: int) -> Sample:
        """Times a run from a data file."""
        return Sample(self._call(data, steps, None))

    def forces(self, data: Path) -> NDArray[np.float64]:
        """Forces on the atoms of a data file, in the order of their ids."""
        with tempfile.TemporaryDirectory(prefix="openmm-") as folder:
            path = Path(folder) / "forces.npy"
            self._call(data, 0, path)
            return np.load(path)

    def _call(self, data: Path, steps: int, forces: Path | None) -> float:
        if importlib.util.find_spec("openmm") is None:
            raise Absent("not installed")
        words = [data, str(steps), str(self.threads), *([forces] if forces else [])]
        answer = _run([sys.executable, "-m", "validation.bench.openmm_peer", *words], {"PYTHONPATH": str(ROOT)})
        return float(answer.splitlines()[-1])


#: Whatever can be timed on the plain liquid.
Contestant = Octant | Lammps | OpenMM


def loop_cost(log: str) -> float:
    """Nanoseconds an atom and step, from the last ``Loop time of`` of a LAMMPS log."""
    words = [line for line in log.splitlines() if line.startswith("Loop time of")][-1].split()
    seconds, steps, count = float(words[3]), int(words[8]), int(words[11])
    return seconds * 1e9 / (steps * count)


def _run(command: Sequence[str | Path], environment: dict[str, str]) -> str:
    """Output of a program; Absent with its last complaint where it fails."""
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=ROOT, env={**os.environ, **environment}, check=False
    )
    if done.returncode != 0:
        lines = [line for line in (done.stderr + "\n" + done.stdout).splitlines() if line.strip()]
        complaint = next((line for line in lines if "ERROR" in line), lines[-1] if lines else "it said nothing")
        # The place in a script that is gone by now says nothing.
        complaint = re.sub(r"\S*scene\.in(:\d+)*:? *", "", complaint)
        raise Absent(f"it ended with {done.returncode}: {complaint}")
    return done.stdout


def _dumped_forces(data: Path, run: Callable[[Script], object]) -> NDArray[np.float64]:
    with tempfile.TemporaryDirectory(prefix="forces-") as folder:
        path = Path(folder) / "forces"
        output = (f"dump forces all custom 1 {path} id fx fy fz", "dump_modify forces sort id format float %.17g")
        run(script(data, 0, output=output))
        return np.loadtxt(path, skiprows=9, usecols=(1, 2, 3), ndmin=2)
