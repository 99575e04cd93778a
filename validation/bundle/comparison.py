"""The comparison with LAMMPS's side from a file: ``python -m validation``, and its JSON as lines of the summary."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from validation.bundle.device import Device
from validation.bundle.outcome import FAILED, PASSED, SKIPPED, Outcome, call

#: LAMMPS's side, beside ``run.sh``.
REFERENCE = "reference.json.gz"

#: Seconds that all scenes may take.
LIMIT = 3600.0

PRECISIONS = ("double", "mixed", "single")


@dataclass(frozen=True)
class Row:
    """One scene in one precision."""

    scene: str
    precision: str
    #: Largest force error over the RMS force (mixed and single: of the atom, where its own is larger).
    force_error: float | None
    #: Thermo rows that are equal in print, "11 of 11"; only double precision promises any.
    rows: str
    #: Neighbors of every atom and list length: equal to LAMMPS's, or not.
    neighbors: str
    #: Checks that are outside their tolerance.
    outside: list[str]

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


def rows(data: Mapping[str, Any]) -> list[Row]:
    """The lines of ``validation.json``; a precision that was not compared has none."""
    found = []
    for scene in data["scenes"]:
        checks = {check["name"]: check for check in scene["checks"]}
        for precision in PRECISIONS:
            prefix = "" if precision == "double" else f"{precision}: "
            own = {
                name.removeprefix(prefix): check
                for name, check in checks.items()
                if name.startswith(prefix) and (prefix or ": " not in name)
            }
            force = own.get("forces, max")
            if force is None and "runs" not in checks:
                continue
            lists = [check for name, check in own.items() if name.startswith(("neighbors", "list length"))]
            equal = bool(lists) and all(check["value"] == 0 for check in lists)
            printed, text = own.get("rows that differ in print"), "-"
            if printed and printed["value"] is not None:
                total = int(printed["detail"].split()[0])
                text = f"{total - int(printed['value'])} of {total}"
            outside = [name for name, check in own.items() if not check["passed"]]
            if "runs" in checks:
                # A scene that did not run at all has this one check, which belongs to every precision.
                outside = [f"did not run: {checks['runs']['detail']}"]
            found.append(
                Row(
                    scene["name"],
                    precision,
                    force["value"] if force else None,
                    text,
                    "equal" if equal else "differ" if lists else "-",
                    outside,
                )
            )
    return found


def run(
    root: Path,
    results: Path,
    scratch: Path,
    environment: Mapping[str, str],
    device: Device,
    backend: str,
    table: list[Row],
) -> Iterator[Outcome]:
    """Every scene and case of the file on ``backend``; the lines of the table are added to ``table``."""
    reason = device.lacks_for_numpy(backend)
    if reason:
        yield Outcome("validation", "all scenes", SKIPPED, reason)
        return
    output, log = results / "validation", Path("validation") / "validation.log"
    words: list[str | Path] = [sys.executable, "-m", "validation", "--reference", root / REFERENCE]
    words += ["--backend", backend, "--output", output, "--precision", *PRECISIONS]
    environment = {**environment, "OCTANT": str(root / "bin" / "octant")}
    (output / "validation.json").unlink(missing_ok=True)
    done = call(words, results / log, environment, LIMIT, scratch)
    try:
        data = json.loads((output / "validation.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        ending = "did not end in time" if done.status is None else f"exit status {done.status}"
        said = "".join(done.output.splitlines()[-1:])
        yield Outcome("validation", "all scenes", FAILED, f"{ending}: {said}", seconds=done.seconds, log=str(log))
        return
    table += rows(data)
    outside = {kind: [item["name"] for item in data[kind] if not item["passed"]] for kind in ("scenes", "cases")}
    # An exit status that no scene and no case explains.
    unexplained = "" if done.status == 0 or any(outside.values()) else f"exit status {done.status}"
    for kind, wrong in outside.items():
        detail = ", ".join(wrong) or unexplained or ("" if data[kind] else "nothing was compared")
        verdict = FAILED if detail else PASSED
        seconds = done.seconds if kind == "scenes" else 0.0
        passed = len(data[kind]) - len(wrong)
        yield Outcome("validation", kind, verdict, detail, passed, len(wrong), 0, seconds, str(log))
