"""``python -m validation.bench.gpu``: measures, or renders what was measured."""

from __future__ import annotations

import argparse
import datetime
import importlib.util
import sys
from pathlib import Path

from validation.bench.gpu import measure, tables
from validation.bench.gpu.plan import Plan
from validation.octant_runner import ROOT, find_binary
from validation.report import commit


def main() -> int:
    """Parses the command line; exit 1 where a benchmark failed or a run in it was wrong."""
    arguments = _parser().parse_args()
    failures: list[str] = []
    if not arguments.render:
        try:
            find_binary()
        except FileNotFoundError as error:
            sys.exit(str(error))
        stamp = {"date": datetime.date.today().isoformat(), "commit": commit()}
        failures = measure.run(_plan(arguments), arguments.results, stamp)
        for failure in failures:
            print(failure, file=sys.stderr)
        if not (arguments.results / tables.BENCH).exists():
            return 1
    folder = arguments.render or arguments.results
    if importlib.util.find_spec("matplotlib") is None:
        print(f"no matplotlib here: python -m validation.bench.gpu --render {folder} makes page and figure elsewhere")
        return 1 if failures else 0
    from validation.bench.gpu import figure, page

    page.write(folder)
    figure.write(folder)
    print(f"wrote {folder}")
    return 1 if failures else 0


def _plan(arguments: argparse.Namespace) -> Plan:
    plan = Plan.quick() if arguments.quick else Plan()
    return plan.changed(
        sizes=arguments.sizes,
        backend=arguments.backend,
        limit=arguments.limit,
        rounds=arguments.rounds,
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m validation.bench.gpu", description="Time octant beside OpenMM on the same GPU."
    )
    default = ROOT / "output" / "bench-gpu"
    add = parser.add_argument
    add("--results", type=Path, default=default, metavar="DIR", help="folder for tables, page and figure")
    add("--render", type=Path, metavar="DIR", help="measure nothing: page and figure of the tables in this folder")
    add(
        "--sizes",
        type=int,
        nargs="+",
        metavar="N",
        help="numbers of atoms; scenes are compared at the largest that fits",
    )
    add("--quick", action="store_true", help="two small sizes, a round: shows that everything works")
    add("--rounds", type=int, metavar="K", help="rounds of each size (3)")
    add(
        "--limit",
        type=float,
        metavar="SECONDS",
        help="what does not fit into this time is left out, the largest first (470)",
    )
    add("--backend", choices=("cuda", "cpu"), help="cuda, or cpu to try the benchmark without a GPU")
    return parser


if __name__ == "__main__":
    sys.exit(main())
