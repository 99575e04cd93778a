"""``python -m validation.paper DIR``: figures and verdict from the CSV files of ``octant paper`` in DIR."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from validation.paper import figures, page
from validation.paper.layout import Unfit
from validation.paper.results import Results


def main() -> int:
    """Parses the command line; exit 1 where a file is missing, or nothing of it is whole."""
    parser = argparse.ArgumentParser(prog="python -m validation.paper", description=__doc__)
    parser.add_argument(
        "folders",
        type=Path,
        nargs="+",
        metavar="DIR",
        help="folder with the CSV files of `octant paper`; figures go there too. Several folders share the page",
    )
    parser.add_argument(
        "--page", type=Path, metavar="FILE", help="where the verdict goes (paper.md in the first folder)"
    )
    arguments = parser.parse_args()
    runs = []
    for folder in arguments.folders:
        try:
            runs.append(Results.read(folder))
        except FileNotFoundError as error:
            sys.exit(
                f"{error.filename}: there is no such file; `octant paper --out {folder}` writes it, unless it is "
                "interrupted or every size is beyond those of the experiment"
            )
        except Unfit as error:
            sys.exit(f"{error}; `octant paper --out {folder}` writes it anew")
    written = [path for results in runs for path in figures.write(results)]
    verdict = arguments.page or arguments.folders[0] / "paper.md"
    page.write(runs, verdict)
    print("wrote " + ", ".join(str(path) for path in [*written, verdict]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
