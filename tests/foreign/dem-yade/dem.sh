#!/usr/bin/env bash
# The DEM as a command: YADE reads its own options only, so that ours go by the environment. The answer goes to file 3, what
# YADE prints of itself nowhere.
here=$(cd "$(dirname "$0")" && pwd)
export BEDLOAD_LINK=$here/../python
BEDLOAD_WORDS=$(python3 -c 'import json, sys; print(json.dumps(sys.argv[1:]))' "$@")
export BEDLOAD_WORDS
export PYTHONPATH=${BEDLOAD_YADE_PYTHON:-$here/../../../target/foreign/yade}
export OMP_NUM_THREADS=1
exec yade -n -x "$here/dem.py" 3>&1 > /dev/null
