"""The machine: processor, cores, instruction sets, caches, and the clock that cycles are counted with."""

from __future__ import annotations

import importlib.metadata
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

#: Flags of /proc/cpuinfo that decide how wide the pair loop can be.
_FLAGS = re.compile(r"sse2|sse4_2|avx|avx2|fma|avx512\w+|asimd|sve2?")

#: Dependent exclusive-ors with a register: every processor of the last twenty years takes one cycle for each, and none
#: folds several into one, as newer ones do with additions of a constant.
_SPIN = r"""
#include <stdio.h>
#include <time.h>
#if defined(__x86_64__)
#define STEP "xorq %1, %0\n\t"
#elif defined(__aarch64__)
#define STEP "eor %0, %0, %1\n\t"
#else
#error unknown
#endif
#define TEN(x) x x x x x x x x x x
int main(void) {
    unsigned long a = 1, b = 3;
    double best = 0;
    for (int repeat = 0; repeat < 20; ++repeat) {
        struct timespec start, end;
        clock_gettime(CLOCK_MONOTONIC, &start);
        for (int i = 0; i < 100000; ++i) __asm__ volatile(TEN(TEN(STEP)) : "+r"(a) : "r"(b));
        clock_gettime(CLOCK_MONOTONIC, &end);
        double rate = 1e7 / ((end.tv_sec - start.tv_sec) + 1e-9 * (end.tv_nsec - start.tv_nsec));
        if (rate > best) best = rate;
    }
    printf("%.0f\n", best);
    return 0;
}
"""


def describe() -> str:
    """Processor, cores and instruction sets in one line."""
    about = _lscpu()
    model = about.get("Model name") or about.get("Architecture") or "unknown processor"
    flags = [flag for flag in about.get("Flags", "").split() if _FLAGS.fullmatch(flag)]
    count = physical_cores()
    return f"{model}, {count} core{'' if count == 1 else 's'}" + (f", {' '.join(flags)}" if flags else "")


def caches() -> str:
    """Cache sizes, those of all cores together."""
    about = _lscpu()
    names = {"L1d": ("L1d cache", "L1d"), "L2": ("L2 cache", "L2"), "L3": ("L3 cache", "L3")}
    found = {name: next((about[key] for key in keys if key in about), None) for name, keys in names.items()}
    return ", ".join(f"{name} {size.split(' (')[0]}" for name, size in found.items() if size)


def physical_cores() -> int:
    """Physical cores that this process may use: hardware threads of one core count once."""
    try:
        allowed = os.sched_getaffinity(0)
        lines = subprocess.run(["lscpu", "-p=cpu,core,socket"], capture_output=True, text=True, check=True).stdout
        cores = {line.split(",", 1)[1] for line in lines.splitlines() if line[:1].isdigit() and _cpu(line) in allowed}
        return len(cores) or len(allowed)
    except (AttributeError, OSError, subprocess.CalledProcessError):
        return os.cpu_count() or 1


def _cpu(line: str) -> int:
    return int(line.split(",", 1)[0])


def version(package: str) -> str:
    """Version of an installed package, or that it is not installed."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def clock() -> tuple[float, str]:
    """The clock in Hz, and where it is from: a timed spin, or what the kernel says; 0 where neither tells."""
    if rate := _spin():
        return rate, "a spin of dependent one-cycle instructions"
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    rates = [float(line.split(":")[1]) for line in lines if line.startswith("cpu MHz")]
    return (max(rates) * 1e6, "cpu MHz of /proc/cpuinfo") if rates else (0.0, "nothing: the machine does not tell")


def _spin() -> float:
    """Cycles a second of one core under load, or 0 without a C compiler."""
    compiler = shutil.which("cc")
    if not compiler:
        return 0.0
    with tempfile.TemporaryDirectory(prefix="spin-") as folder:
        source, program = Path(folder) / "spin.c", Path(folder) / "spin"
        source.write_text(_SPIN, encoding="utf-8")
        try:
            subprocess.run([compiler, "-O2", "-o", program, source], capture_output=True, check=True)
            return float(subprocess.run([program], capture_output=True, text=True, check=True).stdout)
        except (OSError, subprocess.CalledProcessError, ValueError):
            return 0.0


def _lscpu() -> dict[str, str]:
    """What lscpu says, by its fields; empty where there is no lscpu."""
    environment = {**os.environ, "LC_ALL": "C"}
    try:
        text = subprocess.run(["lscpu"], capture_output=True, text=True, env=environment, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return {}
    pairs = (line.split(":", 1) for line in text.splitlines() if ":" in line)
    return {name.strip(): value.strip() for name, value in pairs}
