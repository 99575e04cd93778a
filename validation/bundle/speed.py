"""The benchmark: ``python -m validation.bench.gpu``, with OpenMM where its wheels lie beside the bundle."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from validation.bundle.device import Device
from validation.bundle.outcome import FAILED, PASSED, SKIPPED, Outcome, call

#: Wheels of OpenMM, in a folder beside that of the bundle; ``make gpu-peers`` fetches them.
PEERS = "gpu-peers"

#: Where the CUDA toolkit is, unless CUDA_HOME says otherwise: OpenMM needs its NVRTC and cuFFT.
_TOOLKIT = "/usr/local/cuda"

#: Seconds, unless others are asked for.
LIMIT = 470.0

#: Seconds beyond the limit of the benchmark itself, for what it writes at its end.
_GRACE = 120.0


def with_peers(root: Path, scratch: Path, environment: Mapping[str, str]) -> tuple[dict[str, str], str]:
    """The environment in which OpenMM is found, and what there is to say of it."""
    wheels = sorted((root.parent / PEERS).glob("*.whl"))
    if not wheels:
        return dict(environment), "no wheels of OpenMM beside the bundle"
    site = scratch / PEERS
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--target", site, *wheels]
    done = subprocess.run(install, capture_output=True, text=True, check=False)
    if done.returncode:
        return dict(environment), f"OpenMM could not be installed: {''.join(done.stderr.strip().splitlines()[-1:])}"
    libraries = Path(environment.get("CUDA_HOME", _TOOLKIT)) / "lib64"
    found = {"PYTHONPATH": [str(site)], "LD_LIBRARY_PATH": [str(libraries)]}
    joined = {name: os.pathsep.join([*paths, *filter(None, [environment.get(name)])]) for name, paths in found.items()}
    return {**environment, **joined}, ""


def run(
    root: Path,
    results: Path,
    scratch: Path,
    environment: Mapping[str, str],
    device: Device,
    backend: str,
    limit: float,
    words: Sequence[str],
) -> Iterator[Outcome]:
    """Measures; tables, page and figure go to the folder of results itself."""
    name = "octant beside OpenMM"
    reason = device.lacks_for_numpy(backend)
    if reason:
        yield Outcome("bench", name, SKIPPED, reason)
        return
    environment, said = with_peers(root, scratch, environment)
    environment = {**environment, "OCTANT": str(root / "bin" / "octant")}
    command = [sys.executable, "-m", "validation.bench.gpu", "--results", results, "--backend", backend]
    command += ["--limit", f"{limit:g}", *words]
    # The benchmark's modules are found here whatever is found first for OpenMM.
    environment["PYTHONPATH"] = os.pathsep.join([str(root), *filter(None, [environment.get("PYTHONPATH")])])
    done = call(command, results / "bench.log", environment, limit + _GRACE, scratch)
    verdict = PASSED if done.status == 0 else FAILED
    wrong = "did not end in time" if done.status is None else "".join(done.output.splitlines()[-1:])
    yield Outcome("bench", name, verdict, said if verdict == PASSED else wrong, seconds=done.seconds, log="bench.log")
