"""``python -m validation.stability``: the suite of stiff, extreme, overflowing and long scenes in its long form, and the page made
of what it measured; exit 1 where something fails.

The suite is ``tests/stability``; it writes a line of JSON for each check, and ``validation/truth`` adds its own. Tests that stand
elsewhere and belong to the table are run by name.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from validation import report
from validation.bundle import suites
from validation.bundle.outcome import FAILED, PASSED, SKIPPED
from validation.markdown import table
from validation.octant_runner import ROOT

PAGE = ROOT / "validation" / "stability.md"

_HEADERS = (
    "case",
    "backend",
    "precision",
    "checks",
    "nearest to its bound",
    "value",
    "bound",
    "verdict",
    "where the bound comes from",
)

_TITLES = {
    "stiff": "Stiff",
    "extreme geometry": "Extreme geometry",
    "overflow": "Overflow",
    "force error": "Force error",
    "conservation": "Conservation and symmetry",
    "external truth": "External truth",
}


@dataclass(frozen=True)
class Elsewhere:
    """A test of another file that belongs to the table."""

    section: str
    case: str
    suite: str
    test: str
    #: What it is held to, and why it may be off by that.
    bound: str


ELSEWHERE = (
    Elsewhere("Extreme geometry", "the same forces far from the origin", "physics",
              "the_same_scene_far_from_the_origin_has_the_same_forces",
              "twice the error that a force may have: either scene has its own"),
    Elsewhere("Extreme geometry", "one cell of 1e6 sigma", "physics",
              "cells_too_large_for_fixed_point_are_computed_in_double",
              "1e-6 of the force or of the RMS force, in every precision: pairs are computed in f64, and forces are kept in f32"),
    Elsewhere("Extreme geometry", "lists by definition in random boxes, on faces and mid-planes, all searches", "neighbors",
              "all_searches_give_the_same_pairs",
              "sets of pairs with their images: equal, nothing is tolerated"),
    Elsewhere("Extreme geometry", "distance R exactly, across a side too", "neighbors",
              "a_distance_of_exactly_r_counts_across_a_side_too",
              "sets of pairs: equal"),
    Elsewhere("Extreme geometry", "every image in a box below R", "neighbors",
              "a_box_smaller_than_r_shows_every_image",
              "sets of pairs with their images: equal"),
    Elsewhere("Extreme geometry", "zero and one particle: lists", "neighbors",
              "no_particle_has_no_neighbor_and_one_none",
              "no pairs"),
    Elsewhere("Extreme geometry", "zero and one particle: runs", "physics",
              "a_gas_of_no_or_one_particle_runs",
              "as many particles as before, a finite energy"),
    Elsewhere("Extreme geometry", "all in one cell, all in one point", "neighbors",
              "particles_in_one_point_or_one_cell_are_all_neighbors",
              "N (N - 1) / 2 pairs"),
    Elsewhere("Extreme geometry", "memory follows particles, not volume", "neighbors",
              "memory_follows_particles_not_volume",
              "less than twice the bytes in a box of 1e6 instead of 60 along each edge"),
    Elsewhere("Stiff", "no rounding leaves a particle beyond a wall", "fixes",
              "no_rounding_leaves_a_particle_beyond_a_wall",
              "none of 120 is outside or lost in 600 steps, each with a list build"),
    Elsewhere("Overflow", "coincident atoms: the stop names both and where", "physics",
              "a_broken_force_names_atom_place_and_neighbor",
              "ids, place and distance: equal; the message word for word"),
    Elsewhere("Overflow", "a crowd of overlaps under fix nve/limit", "fixes",
              "limited_steps_take_overlaps_apart_and_are_never_longer",
              "each step at most the limit and a rounding; energy from above 1e8 to below 1e3"),
    Elsewhere("Determinism", "1, 2, 3 and 5 threads, the same bits", "physics",
              "threads_do_not_change_a_bit_and_searches_none_but_the_order_of_sums",
              "bits: equal"),
    Elsewhere("Determinism", "random forces know neither threads nor the order of atoms", "thermostats",
              "random_forces_know_neither_threads_nor_the_order_of_atoms",
              "bits: equal"),
    Elsewhere("Determinism", "repeated runs on a GPU, the same bits", "cuda_repeat",
              "a_run_repeats_in_every_bit_with_and_without_an_inner_list",
              "bits: equal"),
    Elsewhere("External truth", "a cutoff with its tail correction is a longer cutoff", "tail",
              "a_liquid_cut_short_with_its_tail_is_one_cut_later",
              "a tenth of the tail: g(r) is off 1 by a few percent at the third shell, either way"),
    Elsewhere("External truth", "fix langevin: temperature and Maxwell's velocities", "thermostats",
              "langevin_brings_free_particles_to_their_temperature_and_to_maxwells_velocities",
              "4 standard errors, sqrt(2 / n) of a mean of n squares, and 1.2 dt / damp of the fourth moment"),
    Elsewhere("External truth", "fix nvt: its equations of motion", "thermostats",
              "a_chain_follows_its_equations_of_motion",
              "second order: a step of half the length has a quarter of the error, to a tenth and rounding"),
)  # fmt: skip

#: Key of the line of a file of checks that says where they are from.
_ORIGIN = "origin"

HOLDS, FAILS, NOT_RUN = "holds", "**fails**", "not run"

_WORDS = {PASSED: HOLDS, FAILED: FAILS, SKIPPED: NOT_RUN}

#: Its test needs a GPU.
_GPU_ALONE = "cuda_repeat"


@dataclass(frozen=True)
class Line:
    """A line of the table: all checks of a case on one backend in one precision, and the one nearest to its bound."""

    section: str
    case: str
    backend: str
    precision: str
    checks: int
    measured: str
    value: float
    bound: float
    holds: bool
    reason: str


def read_rows(paths: Iterable[Path]) -> list[dict[str, Any]]:
    """Checks as the suite has written them, in the order of the files."""
    return [row for row in _read(paths) if _ORIGIN not in row]


def read_origins(paths: Iterable[Path]) -> list[str]:
    """Where and of which commit checks that were kept are, as their files have it."""
    return [row[_ORIGIN] for row in _read(paths) if _ORIGIN in row]


def _read(paths: Iterable[Path]) -> list[dict[str, Any]]:
    text = "\n".join(path.read_text(encoding="utf-8") for path in paths)
    return [json.loads(line) for line in text.splitlines() if line.strip()]


def _here() -> str:
    return f"{report.machine()}, commit {report.commit()}"


def lines_of(rows: Iterable[dict[str, Any]]) -> list[Line]:
    """One line for each case, backend and precision; a check that fails goes before all that hold."""
    lines: dict[tuple[str, ...], Line] = {}
    for row in rows:
        key = (row["section"], row["case"], row["backend"], row["precision"])
        line = Line(*key, 1, row["measured"], float(row["value"]), float(row["bound"]), row["holds"], row["reason"])
        before = lines.get(key)
        checks = before.checks + 1 if before else 1
        worst = line if before is None or _badness(line) > _badness(before) else before
        lines[key] = replace(worst, checks=checks)
    order = list(_TITLES)
    return sorted(lines.values(), key=lambda line: (order.index(line.section), line.case, line.backend, line.precision))


def _badness(line: Line) -> tuple[bool, float]:
    return (not line.holds, line.value / line.bound if line.bound > 0.0 else line.value)


@dataclass(frozen=True)
class Gpu:
    """What ``run.sh`` found on a GPU: where, and the verdict on each test by suite and name."""

    where: str
    tests: dict[tuple[str, str], str]


def read_gpu(folder: Path) -> Gpu:
    """The results of ``run.sh`` as it leaves them; a suite whose log is not there has not been run."""
    about = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    name = about["card"].split(":")[-1].split(",")[0].strip()
    tests: dict[tuple[str, str], str] = {}
    for outcome in about["outcomes"]:
        log = folder / outcome["log"]
        if outcome["part"] == "tests" and log.is_file():
            suite, found = outcome["name"].split()[0], suites.verdicts(log.read_text(encoding="utf-8"))
            tests |= {(suite, test): _WORDS[verdict] for test, verdict in found.items()}
    return Gpu(f"{name}, driver {about['driver']}, commit {about['commit']}", tests)


def page(
    lines: Sequence[Line],
    elsewhere: Sequence[tuple[Elsewhere, str]],
    form: str,
    gpu: Gpu | None = None,
    origins: Sequence[str] = (),
) -> str:
    """The page as Markdown; `origins` are where the checks are from, if not from here."""
    found = gpu.tests if gpu else {}
    verdicts = [(one, verdict, found.get((one.suite, one.test), NOT_RUN)) for one, verdict in elsewhere]
    failed = {line.case for line in lines if not line.holds} | {one.case for one, *both in verdicts if FAILS in both}
    count, cases = sum(line.checks for line in lines), len({line.case for line in lines})
    text = [
        "# Stability: stiff, extreme, overflowing and long scenes",
        "",
        f"{count} checks of {cases} cases ({form}) by `make stability`, {'; '.join(origins) or _here()}"
        + (f"; tests of other files on a GPU: {gpu.where}. " if gpu else ". ")
        + (f"**{len(failed)} cases fail.**" if failed else "All hold."),
        "",
        "Each line is a case on one backend in one precision, on every instruction set there is, with the check that came nearest "
        "to its bound. A check that begins with *not* is 1 where something did not hold.",
        "",
    ]
    for section, title in _TITLES.items():
        body = [
            (line.case, line.backend, line.precision, str(line.checks), line.measured, f"{line.value:.2g}",
             f"{line.bound:.2g}", HOLDS if line.holds else FAILS, line.reason)
            for line in lines if line.section == section
        ]  # fmt: skip
        text += [f"## {title}", "", *table(_HEADERS, body)] if body else []
    if elsewhere:
        text += ["## Cases that other tests have", ""]
        body = [(one.section, one.case, f"`tests/{one.suite}.rs`: {one.test}", one.bound, *both) for one, *both in verdicts]
        text += [*table(("section", "case", "test", "held to", "here", "GPU"), body)]
    text += [_NOTES.strip(), ""]
    return "\n".join(text)


_NOTES = """
## What is to be known

- In mixed and single precision pair forces are antisymmetric to the bit (differences of fixed-point coordinates are), and the sums of
  them are not: momentum grows as a random walk of their rounding, in single precision of that of velocities.
- In double precision a position seen across a periodic side is rounded as the other side is, in LAMMPS's order of operations, whose
  trajectories octant has to the bit; the force error grows with the length of the box, eps L U''. Mixed and single precision have
  differences of fixed-point coordinates, and it does not.
- NIST's values are of Monte Carlo with an energy that jumps at the cutoff; dynamics has the forces below it alone, and so the ensemble of
  the energy that is shifted to zero there. At a cutoff of 3 sigma the pressure of these liquids is lower by 0.008 to 0.009
  for that, and U by 0.0005 to 0.0008 (a pressure lower by 0.001 at 4 sigma). It is taken into account by weights
  exp(-pairs U(cutoff) / T), pairs being those within the cutoff; so is the kinetic pressure of one atom, density T / N = 0.0013, which
  a system without momentum lacks (in LAMMPS as well). The equation of state is compared at longer cutoffs, where this is below what
  equations of state differ by.
- A particle that ends a step exactly on an upper fixed side is lost, as in LAMMPS: a box ends before its upper side, a wall puts back what
  is beyond it.
- Forces in f32 are worked out in units of the fixed-point grid: they end about 1e8 before f32 does, at 3e30 epsilon / sigma or so.
"""


def run_suite(flags: Sequence[str], rows: Path, form: str) -> None:
    """Runs the suite; what it finds goes to `rows`. A test that did not come to its end is an error."""
    environment = os.environ | {"OCTANT_STABILITY": form, "OCTANT_STABILITY_ROWS": str(rows)}
    command = ["cargo", "test", *flags, "--test", "stability"]
    if subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode != 0:
        sys.exit("a case of the suite did not come to its end")


def run_elsewhere(flags: Sequence[str]) -> list[tuple[Elsewhere, str]]:
    """Runs the tests that stand elsewhere, each by its name."""
    suites = [word for suite in dict.fromkeys(one.suite for one in ELSEWHERE) for word in ("--test", suite)]
    names = list(dict.fromkeys(one.test for one in ELSEWHERE))
    command = ["cargo", "test", "--no-fail-fast", *flags, *suites, "--", "--exact", "--show-output", *names]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return judge(done.stdout)


def run_truth(rows: Path, form: str) -> None:
    """Adds what is known of the Lennard-Jones fluid without octant, in every precision on the backend that OCTANT_TEST_BACKEND names
    (the processor), to `rows`.
    """
    # What these rest on takes a second to import, and none of it is needed to make a page of rows.
    from validation.truth import ensembles, states

    with rows.open("a", encoding="utf-8") as file:
        for precision in ("double", "mixed", "single"):
            for checks in (states.checks, ensembles.checks):
                for check in checks(long=form == "full", precision=precision):
                    file.write(json.dumps(check.row(precision)) + "\n")


def judge(output: str) -> list[tuple[Elsewhere, str]]:
    """Verdicts from what the tests have printed; a test that is not there fails."""
    results = suites.verdicts(output)

    def verdict(one: Elsewhere) -> str:
        result = results.get(one.test, SKIPPED if one.suite == _GPU_ALONE else FAILED)
        # Where there is no GPU, tests of all backends say so and run on the CPU.
        return HOLDS if result == SKIPPED and one.suite != _GPU_ALONE else _WORDS[result]

    return [(one, verdict(one)) for one in ELSEWHERE]


def main() -> int:
    """Parses the command line, runs, writes the page."""
    parser = argparse.ArgumentParser(prog="python -m validation.stability", description=__doc__)
    files = {"type": Path, "metavar": "FILE"}
    parser.add_argument("--rows", nargs="+", help="checks of runs that are over: the suite is not run", **files)
    parser.add_argument("--gpu", help="results of the bundle's `run.sh` on a GPU, whose checks --rows has", **files)
    parser.add_argument("--keep", help="where the checks of this run go", **files)
    parser.add_argument("--page", default=PAGE, help="where the page goes (validation/stability.md)", **files)
    parser.add_argument("--short", action="store_true", help="the form that `make test` runs")
    parser.add_argument("--cargo", default="--release", metavar="FLAGS", help="flags of `cargo test` (--release)")
    arguments = parser.parse_args()
    form = "short" if arguments.short else "full"
    origins: list[str] = []
    if arguments.rows:
        rows, origins = read_rows(arguments.rows), read_origins(arguments.rows)
    else:
        with tempfile.TemporaryDirectory(prefix="stability-") as folder:
            path = arguments.keep or Path(folder) / "rows.jsonl"
            path.write_text(json.dumps({_ORIGIN: _here()}) + "\n", encoding="utf-8")
            run_suite(arguments.cargo.split(), path, form)
            run_truth(path, form)
            rows = read_rows([path])
    if not rows:
        sys.exit("the suite has checked nothing")
    gpu = read_gpu(arguments.gpu) if arguments.gpu else None
    elsewhere = run_elsewhere(arguments.cargo.split())
    lines = lines_of(rows)
    arguments.page.write_text(page(lines, elsewhere, f"{form} form", gpu, origins), encoding="utf-8")
    failed = [line for line in lines if not line.holds]
    for line in failed:
        found = f"{line.measured} {line.value:.3g}, at most {line.bound:.3g}"
        print(f"{line.case}, {line.backend} {line.precision}: {found}")
    broken = [one for one, verdict in elsewhere if verdict == FAILS]
    for one in broken:
        print(f"{one.case}: tests/{one.suite}.rs, {one.test} fails")
    print(f"wrote {arguments.page}")
    return 1 if failed or broken else 0


if __name__ == "__main__":
    sys.exit(main())
