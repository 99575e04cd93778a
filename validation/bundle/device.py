"""The GPU of this machine, as octant and the driver tell of it."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Device:
    """What ``octant info`` says."""

    #: Number, name, compute capability and memory of each GPU.
    cards: list[str] = field(default_factory=list)
    #: Why there is none.
    missing: str = ""
    #: Version of NVRTC, or that it was not found.
    nvrtc: str = "not asked for"
    driver: str = "none"

    @property
    def present(self) -> bool:
        return bool(self.cards)

    def lacks_for_numpy(self, backend: str) -> str:
        """Why what needs ``backend`` and numpy cannot run here; empty where it can."""
        if backend == "cuda" and self.missing:
            return self.missing
        return "" if importlib.util.find_spec("numpy") else f"{sys.executable} has no numpy"

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


def read(info: str, driver: str) -> Device:
    """From the output of ``octant info``."""
    lines = [line.strip() for line in info.splitlines()]
    cards = [line.removeprefix("cuda device ") for line in lines if line.startswith("cuda device ")]
    reasons = [line.removeprefix("no cuda: ") for line in lines if line.startswith("no cuda: ")]
    nvrtc = [line.removeprefix("NVRTC ") for line in lines if line.startswith(("NVRTC ", "no NVRTC"))]
    reason = reasons[0].removeprefix("no CUDA device: ") if reasons else "this octant was built without CUDA"
    return Device(cards, "" if cards else f"no CUDA device: {reason}", nvrtc[0] if nvrtc else "not asked for", driver)


def find(octant: Path) -> Device:
    """Asks the binary; raises OSError or CalledProcessError where it does not even start."""
    done = subprocess.run([octant, "info"], capture_output=True, text=True, check=True)
    return read(done.stdout, _driver())


def _driver() -> str:
    """Version of the kernel driver."""
    if shutil.which("nvidia-smi"):
        ask = ["nvidia-smi", "--query-gpu=driver_version", "--format=csv,noheader"]
        done = subprocess.run(ask, capture_output=True, text=True, check=False)
        if done.returncode == 0 and done.stdout.strip():
            return done.stdout.split()[0]
    try:
        return Path("/proc/driver/nvidia/version").read_text(encoding="utf-8").splitlines()[0]
    except OSError:
        return "none"
