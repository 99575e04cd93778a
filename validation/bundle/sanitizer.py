"""compute-sanitizer over small scenes: memory accesses, races in shared memory, reads of what was never written."""

from __future__ import annotations

import glob
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from validation.bundle.device import Device
from validation.bundle.outcome import FAILED, PASSED, SKIPPED, Done, Outcome, call

TOOLS = ("memcheck", "racecheck", "initcheck")

#: Seconds that one scene may take under one tool.
LIMIT = 120.0

#: What the sanitizer returns where it found something; octant has no such exit code.
_FOUND = 86

_ERRORS = re.compile(r"^=+ (?:ERROR|RACECHECK) SUMMARY: (.+)$", re.MULTILINE)


@dataclass(frozen=True)
class Scene:
    """A script with a few hundred atoms whose list is built several times, and the precisions that it is run in."""

    name: str
    script: str
    variables: Mapping[str, int] = field(default_factory=dict)
    precisions: tuple[str, ...] = ("mixed", "single", "double")
    search: str = "trimmed"


SCENES = (
    Scene("periodic", "inputs/melt.in", {"size": 4, "steps": 100}),
    Scene("free sides, two types", "inputs/cluster.in", {"steps": 100}),
    Scene("small box with images", "validation/scenes/images.in", {"steps": 60}),
    Scene("storage sort, two types", "validation/bundle/sorted.in"),
    Scene("rows shorter than a row has threads", "validation/bundle/few.in"),
    Scene("shrinking sides", "inputs/slab.in", {"size": 4, "steps": 80}, ("mixed",)),
    Scene("atoms are lost", "validation/bundle/open.in", {}, ("mixed", "single")),
    Scene("walls and gravity", "validation/scenes/walls.in", {"steps": 60}),
    Scene("sorted by radix", "inputs/melt.in", {"size": 4, "steps": 60}, ("mixed",), "octant:2.52+zorder+radix"),
    Scene("mostly empty", "inputs/dilute.in", {"size": 4, "steps": 100}, ("mixed",)),
)


def find(environment: Mapping[str, str]) -> str | None:
    """The sanitizer: in PATH, or in a CUDA toolkit."""
    toolkits = [environment.get("CUDA_HOME"), environment.get("CUDA_PATH"), *sorted(glob.glob("/usr/local/cuda*"))]
    folders = [os.path.join(toolkit, "bin") for toolkit in toolkits if toolkit]
    return shutil.which("compute-sanitizer", path=os.pathsep.join([environment.get("PATH", ""), *folders]))


def judge(name: str, done: Done, log: str) -> Outcome:
    """The verdict of a run that has ended; without the sanitizer's own summary nothing was checked: a failure."""
    summaries = _ERRORS.findall(done.output)
    clean = bool(summaries) and all(re.match(r"0 (errors|hazards)\b", summary) for summary in summaries)
    passed = done.status == 0 and clean
    if done.status is None:
        detail = f"did not end within {LIMIT:.0f} s"
    elif not summaries:
        detail = f"no summary, exit status {done.status}"
    else:
        detail = "; ".join(summaries) + ("" if done.status in (0, _FOUND) else f", exit status {done.status}")
    return Outcome(
        "sanitizer", name, PASSED if passed else FAILED, detail, int(passed), int(not passed), 0, done.seconds, log
    )


def run(
    root: Path, results: Path, scratch: Path, environment: Mapping[str, str], device: Device, backend: str
) -> Iterator[Outcome]:
    """Every scene in its precisions under every tool."""
    sanitizer = find(environment)
    reason = device.missing or ("no compute-sanitizer" if sanitizer is None else "")
    if backend == "cpu":
        reason = "it looks at GPU code"
    if reason or sanitizer is None:
        yield Outcome("sanitizer", "all", SKIPPED, reason)
        return
    for tool in TOOLS:
        for scene in SCENES:
            for precision in scene.precisions:
                name = f"{tool}: {scene.name}, {precision}"
                log = Path("sanitizer") / (re.sub(r"\W+", "-", name) + ".log")
                variables = [word for key, value in scene.variables.items() for word in ("-v", f"{key}={value}")]
                words = [sanitizer, "--tool", tool, "--error-exitcode", str(_FOUND), root / "bin" / "octant", "run"]
                words += [root / scene.script, *variables, "--backend", "cuda", "--precision", precision, "--search", scene.search]
                yield judge(name, call(words, results / log, environment, LIMIT, scratch), str(log))
