#!/usr/bin/env bash
# Installs what the DEMs in Python need, from PyPI: tests/foreign/python/install.sh [FOLDER]
# Prints the interpreter, FOLDER/bin/python; by default target/foreign/python/bin/python.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
venv=${1:-${CARGO_TARGET_DIR:-$here/../../../target}/foreign/python}
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt" \
    -e "$here/../../../coupler/python[iceoryx2]" >&2
echo "$(cd "$venv" && pwd)/bin/python"
