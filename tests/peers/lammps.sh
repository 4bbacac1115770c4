#!/usr/bin/env bash
# Bedload's DEM beside LAMMPS gran/hooke/history on the same packings, one core each, one after the other.
#   apt-get install lammps; cargo build --release -p dem-solver --example packing_cost
#   tests/peers/lammps.sh [N STEPS]...
# Stacked layers need time to settle: RELAX sub-steps come before the timed ones (300).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
cost=${COST:-${CARGO_TARGET_DIR:-$here/../../target}/release/examples/packing_cost}
lmp=${LMP:-lmp}
export RELAX=${RELAX:-300}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# one stiffness for all, that of two grains of 2 mm; k_t = 2/7 k_n, gamma_t = gamma_n/2
read -r kn kt gn gt < <(python3 -c "
import math
m=2500*math.pi/6*2e-3**3/2; g=-2*math.log(0.3)/1e-4; k=m*((math.pi/1e-4)**2+(g/2)**2)
print(k, k*2/7, g, g/2)")
[ $# -gt 0 ] || set -- 1000 20000 8000 3000 56000 500
while [ $# -gt 1 ]; do
  "$cost" "$1" 1 1 write "$work/start.data"
  ours=$("$cost" "$1" "$2" 1)
  (cd "$work" && OMP_NUM_THREADS=1 "$lmp" -in "$here/packing.lmp" -log none -v DATA start.data -v STEPS "$2" -v RELAX "$RELAX" \
    -v KN "$kn" -v KT "$kt" -v GN "$gn" -v GT "$gt" > out)
  echo "$ours"
  python3 - "$work/out" "$ours" <<'P'
import re, sys
text = open(sys.argv[1]).read()
loop, steps, n = re.findall(r"Loop time of ([\d.e-]+) on \d+ procs for (\d+) steps with (\d+) atoms", text)[-1]
use = float(re.findall(r"([\d.]+)% CPU use", text)[-1]) / 100
builds = re.findall(r"Neighbor list builds = (\d+)", text)[-1]
contacts = re.findall(r"^ +\d+ +\d+ +([\d.e+-]+) +([\d.e+-]+) *$", text, re.M)[-1][1]
theirs = float(loop) * use / (int(n) * int(steps)) * 1e9
ours = float(re.search(r"([\d.]+) ns CPU", sys.argv[2]).group(1))
print(f"  LAMMPS: {theirs:.1f} ns CPU; {contacts} contacts per grain; {builds} builds; ratio {theirs / ours:.2f}")
P
  shift 2
done
