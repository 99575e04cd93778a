"""``python -m validation.paper DIR``: draws the CSV files of ``octant paper`` in DIR."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from validation.paper import figures


def main() -> int:
    """Parses the command line; exit 1 where a file is missing."""
    parser = argparse.ArgumentParser(prog="python -m validation.paper", description=__doc__)
    parser.add_argument("folder", type=Path, help="folder with the CSV files of `octant paper`; figures go there too")
    folder = parser.parse_args().folder
    try:
        written = figures.write(folder)
    except FileNotFoundError as error:
        sys.exit(f"{error.filename}: there is no such file; `octant paper --out {folder}` writes it")
    print("wrote " + ", ".join(str(path) for path in written))
    return 0


if __name__ == "__main__":
    sys.exit(main())
