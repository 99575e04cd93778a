"""``python -m validation``: every scene and case through both programs; exit 1 where one is outside its tolerance."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from validation import precisions, report
from validation.cases import all_cases, atoms_by_lammps, compare_case
from validation.check import Check
from validation.compare import SceneResult, compare_scene
from validation.lammps_runner import LammpsError
from validation.octant_runner import ROOT, OctantError, find_binary
from validation.reference import Reference, SceneReference, StaleReference, run_scene
from validation.scene import Scene, all_scenes

#: What keeps one scene or case from being compared; the others are compared all the same.
_FAULTS = (LammpsError, OctantError, StaleReference)


def main() -> int:
    """Parses the command line, compares, writes the report."""
    arguments = _arguments()
    scenes = [scene for scene in all_scenes() if not arguments.only or scene.name in arguments.only]
    if not scenes:
        sys.exit(f"no scene of this name; there are: {', '.join(scene.name for scene in all_scenes())}")
    if arguments.save_reference:
        return _save(arguments, scenes)
    try:
        find_binary()
    except FileNotFoundError as error:
        sys.exit(str(error))
    saved = Reference.load(arguments.reference) if arguments.reference else None
    results: list[SceneResult] = []
    cases: list[Check] = []
    with tempfile.TemporaryDirectory(prefix="validation-") as folder:
        scratch = Path(folder)
        for scene in scenes if saved is None else [scene for scene in scenes if scene.name in saved.scenes]:
            started = time.monotonic()
            try:
                theirs = saved.scenes[scene.name] if saved else _run(scene, scratch, quick=arguments.quick)
                result = compare_scene(
                    scene, theirs, scratch / scene.name, backend=arguments.backend, among=arguments.precision
                )
            except _FAULTS as error:
                result = SceneResult(scene.name, checks=[Check("runs", float("inf"), 0.0, str(error))])
            results.append(result)
            _say(scene.name, result.passed, time.monotonic() - started)
            for check in result.checks:
                if not check.passed:
                    print(f"      {check.name}: {check.value:.3g}, allowed {check.bound:.3g}. {check.detail}")
        for case in [] if arguments.only else all_cases():
            if saved and case.name not in saved.cases:
                continue
            started = time.monotonic()
            try:
                atoms = saved.cases[case.name] if saved else atoms_by_lammps(case, scratch)
                check = compare_case(case, atoms, scratch, backend=arguments.backend)
            except _FAULTS as error:
                check = Check(case.name, float("inf"), 0.0, str(error))
            cases.append(check)
            _say(case.name, check.passed, time.monotonic() - started)
            if not check.passed:
                print(f"      {check.value:.3g} numbers differ. {check.detail}")
    side = saved or Reference.empty(quick=arguments.quick)
    about = report.about(lammps=side.lammps, backend=arguments.backend, quick=side.quick)
    report.write(arguments.output, results, cases, about)
    print(f"wrote {arguments.output}")
    if not results:
        print(f"{arguments.reference} holds none of these scenes: nothing was compared")
    return 0 if results and all(result.passed for result in [*results, *cases]) else 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m validation", description="Compare octant with LAMMPS on the same scripts."
    )
    parser.add_argument("--quick", action="store_true", help="smaller scenes and shorter runs")
    parser.add_argument("--only", metavar="NAME", nargs="+", help="these scenes alone, and no cases")
    parser.add_argument(
        "--output", type=Path, default=ROOT / "validation" / "results", help="folder for table, JSON and plot"
    )
    parser.add_argument("--backend", choices=("cpu", "cuda"), default="cpu", help="octant's engine")
    parser.add_argument(
        "--precision", nargs="+", choices=precisions.ALL, default=precisions.ALL, help="octant's precisions"
    )
    file = parser.add_mutually_exclusive_group()
    file.add_argument(
        "--save-reference",
        metavar="FILE",
        type=Path,
        help="run LAMMPS alone and keep its side in a file (.json, .json.gz)",
    )
    file.add_argument(
        "--reference", metavar="FILE", type=Path, help="compare with LAMMPS's side from such a file, sizes and all"
    )
    arguments = parser.parse_args()
    if arguments.reference and arguments.quick:
        parser.error("--quick: the sizes are those of the file that --reference names")
    if arguments.reference and not arguments.reference.is_file():
        parser.error(f"--reference: there is no file {arguments.reference}")
    return arguments


def _save(arguments: argparse.Namespace, scenes: list[Scene]) -> int:
    """LAMMPS's side of every scene and case, into a file; the first fault ends it."""
    reference = Reference.empty(quick=arguments.quick)
    with tempfile.TemporaryDirectory(prefix="validation-") as folder:
        scratch = Path(folder)
        try:
            for scene in scenes:
                started = time.monotonic()
                reference.scenes[scene.name] = _run(scene, scratch, quick=arguments.quick)
                _say(scene.name, True, time.monotonic() - started)
            for case in [] if arguments.only else all_cases():
                reference.cases[case.name] = atoms_by_lammps(case, scratch)
        except LammpsError as error:
            sys.exit(str(error))
    reference.save(arguments.save_reference)
    print(f"wrote {arguments.save_reference}: {arguments.save_reference.stat().st_size / 2**20:.1f} MiB")
    return 0


def _run(scene: Scene, scratch: Path, *, quick: bool) -> SceneReference:
    """LAMMPS's side of a scene, in a folder of its own."""
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        return run_scene(scene, scene.quick if quick else {}, Path(folder))


def _say(name: str, passed: bool, seconds: float) -> None:
    print(f"{'ok  ' if passed else 'FAIL'}  {name} ({seconds:.1f} s)", flush=True)


if __name__ == "__main__":
    sys.exit(main())
