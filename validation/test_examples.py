"""LAMMPS's own example scripts, unmodified, where Debian's package lammps-examples has put them on the machine."""

from __future__ import annotations

import gzip
import os
from pathlib import Path

import pytest

from validation.lammps_runner import run_lammps
from validation.octant_runner import run_octant

#: Trees with `examples` and `bench`: Debian's package, and one named in the environment. The scripts are LAMMPS's, so
#: none stands in this repository.
TREES = [Path(tree) for tree in (os.environ.get("LAMMPS_TREE"), "/usr/share/lammps") if tree]
EXAMPLES = ["examples/melt/in.melt", "bench/in.lj"]


def find(name: str, scratch: Path) -> Path | None:
    """The example on this machine, unpacked into a folder."""
    for tree in TREES:
        for path, opened in ((tree / name, open), (tree / f"{name}.gz", gzip.open)):
            if path.is_file():
                copy = scratch / path.name.removesuffix(".gz")
                with opened(path, "rb") as source:
                    copy.write_bytes(source.read())
                return copy
    return None


@pytest.mark.parametrize("name", EXAMPLES)
def test_example_runs_unmodified(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = find(name, tmp_path)
    if script is None:
        pytest.skip(
            f"LAMMPS's {name} is not on this machine (Debian: lammps-examples; or name a LAMMPS tree in LAMMPS_TREE)"
        )
    monkeypatch.chdir(tmp_path)
    theirs, ours = run_lammps(script).runs[-1], run_octant(script).runs[-1]
    assert ours.columns == theirs.columns
    assert ours.rows == theirs.rows
    assert ours.statistics == theirs.statistics
