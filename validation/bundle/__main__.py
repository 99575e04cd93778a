"""``run.sh``: the parts that are asked for, then a summary; exit status as in ``summary.STATUS``, 2: a wrong call."""

from __future__ import annotations

import argparse
import datetime
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from validation.bundle import comparison, device, engine, paper, sanitizer, speed, suites, summary
from validation.bundle.outcome import Outcome

ROOT = Path(__file__).resolve().parent.parent.parent
PARTS = ("tests", "sanitizer", "validation", "bench", "paper", "engine")

#: Parts that measure run only where they are asked for.
MEASURING = ("bench", "paper", "engine")


def main() -> int:
    """Parses the command line, runs, writes the summary after every step, so that a run that is cut off leaves one."""
    arguments = _arguments()
    try:
        bundle = json.loads((ROOT / "bundle.json").read_text(encoding="utf-8"))
    except OSError as error:
        sys.exit(f"this runs in the folder that `make gpu-bundle` makes: {error}")
    results = arguments.results.resolve()
    results.mkdir(parents=True, exist_ok=True)
    try:
        found = device.find(ROOT / "bin" / "octant")
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"octant does not start on this machine: {error}")
    about = {
        "date": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        "card": "; ".join(found.cards) or f"none ({found.missing})",
        "driver": found.driver,
        "NVRTC": found.nvrtc,
        "commit": bundle["commit"],
        "LAMMPS": bundle["lammps"],
        "backend": arguments.backend,
    }
    print("\n".join(f"{name}: {value}" for name, value in about.items()), flush=True)
    outcomes: list[Outcome] = []
    table: list[comparison.Row] = []
    with tempfile.TemporaryDirectory(prefix="octant-bundle-") as scratch:
        for outcome in _outcomes(arguments, bundle, results, Path(scratch), found, table, about):
            outcomes.append(outcome)
            counts = f"{outcome.passed} passed, {outcome.failed} failed, {outcome.skipped} skipped"
            print(f"{outcome.verdict:8}{outcome.part}, {outcome.name}: {counts} ({outcome.seconds:.1f} s)", end="")
            print(f"  {outcome.detail}" if outcome.detail else "", flush=True)
            summary.write(results, about, outcomes, table)
    verdict = summary.overall(outcomes)
    print(f"{verdict}; wrote {results / 'summary.md'}")
    return summary.STATUS[verdict]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="run.sh",
        description="Tests octant on this machine's GPU. Exit status: 0 passed, 1 failed, 2 wrong call, 77 nothing "
        "failed, but something could not be run.",
    )
    parser.add_argument(
        "parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}; all but {', '.join(MEASURING)} by default"
    )
    parser.add_argument("--results", type=Path, default=Path("results"), help="folder for summary and logs (results)")
    parser.add_argument(
        "--backend",
        choices=("cuda", "cpu"),
        default="cuda",
        help="engine under test; cpu tries the bundle without a GPU",
    )
    bench = parser.add_argument_group("bench and paper")
    bench.add_argument("--sizes", nargs="+", type=int, metavar="N", help="numbers of atoms or particles")
    bench.add_argument("--quick", action="store_true", help="small sizes, few rounds: shows that everything works")
    bench.add_argument(
        "--limit", type=float, metavar="SECONDS", help=f"time for it ({speed.LIMIT:g}, paper {paper.LIMIT:g})"
    )
    arguments = parser.parse_intermixed_args()
    if unknown := [part for part in arguments.parts if part not in PARTS]:
        parser.error(f"there is no part {', '.join(unknown)}; there are {', '.join(PARTS)}")
    arguments.parts = arguments.parts or [part for part in PARTS if part not in MEASURING]
    return arguments


def _outcomes(
    arguments: argparse.Namespace,
    bundle: dict,
    results: Path,
    scratch: Path,
    found: device.Device,
    table: list[comparison.Row],
    about: Mapping[str, str],
) -> Iterator[Outcome]:
    environment, backend = dict(os.environ), arguments.backend
    if "tests" in arguments.parts:
        everything = [suites.Suite(**suite) for suite in bundle["suites"]]
        yield from suites.run(everything, ROOT, results, scratch, environment, found, backend)
    if "sanitizer" in arguments.parts:
        yield from sanitizer.run(ROOT, results, scratch, environment, found, backend)
    if "validation" in arguments.parts:
        yield from comparison.run(ROOT, results, scratch, environment, found, backend, table)
    if "bench" in arguments.parts:
        words = ["--sizes", *map(str, arguments.sizes)] if arguments.sizes else []
        words += ["--quick"] if arguments.quick else []
        yield from speed.run(ROOT, results, scratch, environment, found, backend, arguments.limit or speed.LIMIT, words)
    if "paper" in arguments.parts:
        limit, sizes = arguments.limit or paper.LIMIT, arguments.sizes or ()
        yield from paper.run(ROOT, results, scratch, environment, found, backend, limit, sizes, arguments.quick)
    if "engine" in arguments.parts:
        yield from engine.run(ROOT, results, scratch, environment, backend, bundle["benches"], about)


if __name__ == "__main__":
    sys.exit(main())
