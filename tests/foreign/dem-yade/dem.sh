#!/usr/bin/env bash
# The DEM as a command: YADE reads its own options only, so that ours go by the environment. The answer goes to file 3, what
# YADE prints of itself nowhere.
here=$(cd "$(dirname "$0")" && pwd)
BEDLOAD_WORDS=$(python3 -c 'import json, sys; print(json.dumps(sys.argv[1:]))' "$@")
export BEDLOAD_WORDS
root=$here/../../..
export PYTHONPATH=${BEDLOAD_YADE_PYTHON:-$root/target/foreign/yade}:$root/coupler/python/src
export OMP_NUM_THREADS=1
exec yade -n -x "$here/dem.py" 3>&1 > /dev/null
