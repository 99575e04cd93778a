#!/bin/sh
# Tests octant on this machine's GPU; `./run.sh --help` lists what can be asked for.
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd) || exit 2
python=${PYTHON:-python3}
command -v "$python" >/dev/null || { echo "run.sh needs Python 3.10 or newer, and there is no $python (PYTHON names another)" >&2; exit 2; }
# Not -m: the folder it is called from may have a package of that name.
PYTHONPATH=$here PYTHONDONTWRITEBYTECODE=1 exec "$python" "$here/validation/bundle/__main__.py" "$@"
