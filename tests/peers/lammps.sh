#!/usr/bin/env bash
# Bedload's DEM beside LAMMPS gran/hooke/history on the same packings, one core each, in turn.
#   apt-get install lammps; cargo build --release -p bedload-dem --example packing_cost
#   tests/peers/lammps.sh [N STEPS | rain N STEPS]...
# Packings at rest are made by Bedload when first asked for, and kept in $PACKINGS. Both codes take the centres and
# radii, and relax RELAX sub-steps (1000; rain: none), as the springs are not handed over. REPEATS turns (3).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
cost=${COST:-${CARGO_TARGET_DIR:-$here/../../target}/release/examples/packing_cost}
lmp=${LMP:-lmp}
keep=${PACKINGS:-${TMPDIR:-/tmp}/bedload-packings}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$keep"
# one stiffness for all, that of two grains of 2 mm; k_t = 2/7 k_n, gamma_t = gamma_n/2
read -r kn kt gn gt < <(python3 -c "
import math
m=2500*math.pi/6*2e-3**3/2; g=-2*math.log(0.3)/1e-4; k=m*((math.pi/1e-4)**2+(g/2)**2)
print(k, k*2/7, g, g/2)")
[ $# -gt 0 ] || set -- 1000 20000 8000 3000 56000 300 rain 8000 3000
while [ $# -gt 1 ]; do
  kind= relax=${RELAX:-1000}
  unset START
  if [ "$1" = rain ]; then kind=rain relax=0; shift; fi
  n=$1 steps=$2
  shift 2
  if [ -z "$kind" ]; then
    # more than 8,000: copies of a packing at rest, one upon the other
    START=$keep/$((n < 8000 ? n : 8000)).txt
    [ -s "$START" ] || "$cost" "$((n < 8000 ? n : 8000))" 1 1 settle "$START"
    export START
  fi
  "$cost" "$n" 1 1 "write${kind:+-$kind}" "$work/start.data"
  : > "$work/pairs"
  for turn in $(seq "${REPEATS:-3}"); do
    RELAX=$relax "$cost" "$n" "$steps" 1 $kind > "$work/ours"
    (cd "$work" && OMP_NUM_THREADS=1 "$lmp" -in "$here/packing.lmp" -log none -v DATA start.data -v STEPS "$steps" \
      -v RELAX "$relax" -v KN "$kn" -v KT "$kt" -v GN "$gn" -v GT "$gt" -v SKIN "${SKIN_LAMMPS:-0.2e-3}" > theirs)
    cat "$work/ours"
    python3 - "$work" <<'P'
import re, statistics, sys
work = sys.argv[1]
text, ours = open(work + "/theirs").read(), open(work + "/ours").read()
loop, steps, n = re.findall(r"Loop time of ([\d.e-]+) on \d+ procs for (\d+) steps with (\d+) atoms", text)[-1]
use = float(re.findall(r"([\d.]+)% CPU use", text)[-1]) / 100
builds = re.findall(r"Neighbor list builds = (\d+)", text)[-1]
contacts = re.findall(r"^ +\d+ +\d+ +([\d.e+-]+) +([\d.e+-]+) *$", text, re.M)[-1][1]
theirs = float(loop) * use / (int(n) * int(steps)) * 1e9
ours = float(re.search(r"([\d.]+) ns CPU", ours).group(1))
open(work + "/pairs", "a").write(f"{ours} {theirs}\n")
turns = [tuple(map(float, line.split())) for line in open(work + "/pairs")]
ratios = [b / a for a, b in turns]
print(f"  LAMMPS: {theirs:.1f} ns CPU; {float(contacts):.2f} contacts per grain; {builds} builds; ratio {ratios[-1]:.2f}"
      f" (least {min(ratios):.2f}, median {statistics.median(ratios):.2f} of {len(ratios)})")
P
  done
done
