"""``python -m validation.bench``: measures, and writes table, page and figure."""

from __future__ import annotations

import argparse
import datetime
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from validation.bench import machine, page
from validation.bench.liquid import Liquids
from validation.bench.plan import MODES, Plan
from validation.bench.rounds import say
from validation.bench.rows import Rows
from validation.bench.sections import SECTIONS
from validation.octant_runner import ROOT, find_binary
from validation.report import commit


def main() -> int:
    """Parses the command line, measures section after section, writes the results after each."""
    arguments = _parser().parse_args()
    try:
        find_binary()
    except FileNotFoundError as error:
        sys.exit(str(error))
    plan = _plan(arguments)
    chosen = [section for section in SECTIONS if not arguments.only or section.NAME in arguments.only]
    # Sections that are not measured now keep what an earlier call wrote, with its date and commit.
    table = arguments.output / "bench.csv"
    kept = Rows.read(table) if arguments.only and table.exists() else Rows()
    rows = Rows(row for row in kept if row.section not in {section.NAME for section in chosen})
    place, date, version = machine.describe(), datetime.date.today().isoformat(), commit()
    with tempfile.TemporaryDirectory(prefix="bench-") as scratch:
        liquids = Liquids(arguments.liquids or Path(scratch), plan)
        for section in chosen:
            rows.rows += section.measure(plan, liquids).stamped(place, date, version)
            page.write(arguments.output, rows, quick=arguments.quick)
    say(f"wrote {arguments.output}")
    print("\n".join(page.readme_lines(rows)))
    return 0


def _plan(arguments: argparse.Namespace) -> Plan:
    """The default plan or the quick one, with what the command line changes."""
    threads = arguments.threads or machine.physical_cores()
    plan = Plan.quick(threads) if arguments.quick else Plan(threads=threads)
    if arguments.sizes:
        sizes = tuple(sorted(arguments.sizes))
        plan = replace(plan, sizes=sizes, main=plan.main if plan.main in sizes else sizes[-1])
    if arguments.rounds:
        plan = replace(plan, rounds=arguments.rounds)
    return replace(plan, floors=tuple(arguments.floor or ()))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m validation.bench", description="Time octant beside LAMMPS and OpenMM on the same liquid."
    )
    names = [section.NAME for section in SECTIONS]
    add = parser.add_argument
    add("--quick", action="store_true", help="few rounds of small liquids, seconds; the numbers are worth nothing")
    add(
        "--sizes",
        type=_size,
        nargs="+",
        metavar="N",
        help="edges of the box in fcc cells, 4 N^3 atoms (10 20 40 63); programs are compared at 20, or the largest",
    )
    add("--rounds", type=_positive, metavar="K", help="rounds in which every contestant runs once (7)")
    add("--threads", type=_positive, metavar="N", help="threads of the runs on all cores (all physical cores)")
    add("--only", nargs="+", choices=names, metavar="SECTION", help=f"measure these alone: {', '.join(names)}")
    add(
        "--floor",
        type=_floor,
        action="append",
        metavar="MODE=CYCLES",
        help="cycles a list entry that the pair loop cannot go below, to compare with; repeatable",
    )
    add("--liquids", type=Path, metavar="DIR", help="keep the melted liquids here for the next call")
    add("--output", type=Path, default=ROOT / "validation" / "results" / "bench", help="folder for the results")
    return parser


def _positive(word: str) -> int:
    value = int(word)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{word} is not positive")
    return value


def _size(word: str) -> int:
    value = int(word)
    if value < 4:
        raise argparse.ArgumentTypeError("a box of fewer than 4 cells is narrower than two cutoffs with their skin")
    return value


def _floor(word: str) -> tuple[str, float]:
    mode, _, cycles = word.partition("=")
    if mode not in MODES:
        raise argparse.ArgumentTypeError(f"{mode} is not one of {', '.join(MODES)}")
    return mode, float(cycles)


if __name__ == "__main__":
    sys.exit(main())
