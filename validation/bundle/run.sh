#!/bin/sh
# Tests octant on this machine's GPU; `./run.sh --help` lists what can be asked for.
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd) || exit 2
python=${PYTHON:-python3}
command -v "$python" >/dev/null || { echo "run.sh needs Python 3.10 or newer, and there is no $python (PYTHON names another)" >&2; exit 2; }
PYTHONPATH=$here PYTHONDONTWRITEBYTECODE=1 exec "$python" -m validation.bundle "$@"
