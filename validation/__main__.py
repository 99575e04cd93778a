"""``python -m validation``: every scene and case through both programs; exit 1 where one is outside its tolerance."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from validation import report
from validation.cases import all_cases, compare_case
from validation.check import Check
from validation.compare import SceneResult, compare_scene
from validation.lammps_runner import LammpsError
from validation.octant_runner import ROOT, OctantError, find_binary
from validation.scene import all_scenes


def main() -> int:
    """Parses the command line, compares, writes the report."""
    parser = argparse.ArgumentParser(
        prog="python -m validation", description="Compare octant with LAMMPS on the same scripts."
    )
    parser.add_argument("--quick", action="store_true", help="smaller scenes and shorter runs")
    parser.add_argument("--only", metavar="NAME", nargs="+", help="these scenes alone, and no cases")
    parser.add_argument(
        "--output", type=Path, default=ROOT / "validation" / "results", help="folder for table, JSON and plot"
    )
    arguments = parser.parse_args()

    scenes = [scene for scene in all_scenes() if not arguments.only or scene.name in arguments.only]
    if not scenes:
        parser.error(f"no scene of this name; there are: {', '.join(scene.name for scene in all_scenes())}")
    try:
        find_binary()
    except FileNotFoundError as error:
        sys.exit(str(error))
    results: list[SceneResult] = []
    with tempfile.TemporaryDirectory(prefix="validation-") as scratch:
        for scene in scenes:
            started = time.monotonic()
            try:
                result = compare_scene(scene, scene.quick if arguments.quick else {}, Path(scratch) / scene.name)
            except (LammpsError, OctantError) as error:
                result = SceneResult(scene.name, checks=[Check("runs", float("inf"), 0.0, str(error))])
            results.append(result)
            _say(scene.name, result.passed, time.monotonic() - started)
            for check in result.checks:
                if not check.passed:
                    print(f"      {check.name}: {check.value:.3g}, allowed {check.bound:.3g}. {check.detail}")
        cases: list[Check] = []
        for case in [] if arguments.only else all_cases():
            started = time.monotonic()
            try:
                check = compare_case(case, Path(scratch))
            except (LammpsError, OctantError) as error:
                check = Check(case.name, float("inf"), 0.0, str(error))
            cases.append(check)
            _say(case.name, check.passed, time.monotonic() - started)
            if not check.passed:
                print(f"      {check.value:.3g} numbers differ. {check.detail}")
    report.write(arguments.output, results, cases, quick=arguments.quick)
    print(f"wrote {arguments.output}")
    return 0 if all(result.passed for result in [*results, *cases]) else 1


def _say(name: str, passed: bool, seconds: float) -> None:
    print(f"{'ok  ' if passed else 'FAIL'}  {name} ({seconds:.1f} s)", flush=True)


if __name__ == "__main__":
    sys.exit(main())
