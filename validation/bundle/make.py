"""``make gpu-bundle``: gathers the bundle on the machine that has Rust and LAMMPS.

``python -m validation.bundle.make [cargo's flags]`` makes ``bundle/octant-gpu/`` and ``bundle/octant-gpu.tar.xz``.
"""

from __future__ import annotations

import datetime
import json
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path
from typing import Any

from validation import report
from validation.bundle.comparison import REFERENCE
from validation.octant_runner import ROOT
from validation.reference import Reference

FOLDER = ROOT / "bundle" / "octant-gpu"

_MEBI = 2**20

#: Largest archive, bytes: small enough to be carried anywhere.
LARGEST = 60 * _MEBI

#: What goes in as it is. Python's tests stay behind: they need LAMMPS and other packages.
FILES = (
    "inputs/*",
    "inputs/paper/*",
    "validation/*.py",
    "validation/scenes/*",
    "validation/bench/*.py",
    "validation/bench/*.csv",
    "validation/bench/gpu/*.py",
    "validation/bench/sections/*.py",
    "validation/bundle/*",
    "LICENSE-*",
)
LEFT_OUT = re.compile(r"/(test_\w+|conftest|trajectories)\.py$|/make\.py$|/run\.sh$")

#: Suites that do nothing on a GPU and stay behind: the reading of scripts, the benchmark's command, allocations of the CPU
#: engine, kernels compiled for architectures that are not there.
AT_HOME = {
    "allocations",
    "bench",
    "cuda_kernels",
    "judging",
    "paper_command",
    "report",
    "report_scenes",
    "script_reader",
    "walk",
    "wrong_input",
}

#: A test source that asks for the backends that OCTANT_TEST_BACKEND leaves.
_ENGINES = re.compile(r"(?<!\w)variants\(\)")


def main() -> int:
    """Builds, copies, runs LAMMPS, packs; exit 1 where the result is too large."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    files = [file for pattern in FILES for file in sorted(ROOT.glob(pattern)) if file.is_file()]
    for file in (file for file in files if not LEFT_OUT.search(str(file))):
        target = FOLDER / file.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, target)
    shutil.copy(ROOT / "validation" / "bundle" / "run.sh", FOLDER / "run.sh")
    contents = _binaries(sys.argv[1:])
    subprocess.run([sys.executable, "-m", "validation", "--save-reference", FOLDER / REFERENCE], cwd=ROOT, check=True)
    about = {
        "commit": report.commit(),
        "date": datetime.date.today().isoformat(),
        "rust": subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True).stdout.strip(),
        "lammps": Reference.empty(quick=False).lammps,
        **contents,
    }
    (FOLDER / report.STAMP.name).write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
    packed = FOLDER.with_suffix(".tar.xz")
    with tarfile.open(packed, "w:xz") as archive:
        archive.add(FOLDER, FOLDER.name)
    words, fits = size(packed, FOLDER, LARGEST)
    print(words, file=sys.stdout if fits else sys.stderr)
    return 0 if fits else 1


def size(packed: Path, folder: Path, largest: int) -> tuple[str, bool]:
    """An archive's size in words, and whether it is at most ``largest`` bytes; if not, the words name what is large in its folder."""
    sizes = {path.relative_to(folder): path.stat().st_size for path in folder.rglob("*") if path.is_file()}
    total = packed.stat().st_size
    words = f"{packed.name}: {total / _MEBI:.1f} MiB, allowed are {largest / _MEBI:.1f}"
    if total > largest:
        first = sorted(sizes, key=lambda path: -sizes[path])[:5]
        words += "; the largest, MiB: " + ", ".join(f"{path} {sizes[path] / _MEBI:.1f}" for path in first)
    return words, total <= largest


def _binaries(flags: list[str]) -> dict[str, Any]:
    """Builds every target with cargo and copies the executables, stripped; which there are, for ``bundle.json``."""
    call = ["cargo", "test", *flags, "--all-targets", "--no-run", "--message-format=json-render-diagnostics"]
    built = subprocess.run(call, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout
    suites, benches = [], []
    for message in map(json.loads, built.splitlines()):
        executable = message.get("executable")
        if not executable:
            continue
        target, is_test = message["target"], message["profile"]["test"]
        kind, source = target["kind"][0], Path(target["src_path"])
        if kind == "bin" and not is_test:
            _strip(executable, "bin/octant")
        elif kind == "bench":
            _strip(executable, f"benches/{target['name']}")
            benches.append(f"benches/{target['name']}")
        elif is_test and target["name"] not in AT_HOME and _has_tests(executable):
            name = {"lib": "unit tests", "bin": "unit tests of the binary"}.get(kind, target["name"])
            file = f"suites/{name.replace(' ', '-')}"
            _strip(executable, file)
            engines = kind == "test" and bool(_ENGINES.search(source.read_text(encoding="utf-8")))
            suites.append({"name": name, "file": file, "engines": engines})
    return {"suites": sorted(suites, key=lambda suite: suite["name"]), "benches": benches}


def _has_tests(executable: str) -> bool:
    listed = subprocess.run([executable, "--list"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return any(line.endswith(": test") for line in listed.splitlines())


def _strip(executable: str, file: str) -> None:
    target = FOLDER / file
    target.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(["strip", "--strip-all", "-o", target, executable], check=True)


if __name__ == "__main__":
    sys.exit(main())
