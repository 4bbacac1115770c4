#!/usr/bin/env bash
# The fifteen oblique collisions of scenes/oblique-collision.toml in LAMMPS (gran/hooke/history): error and cost, as points
# for that scene's chart.
#   apt-get install lammps; tests/peers/oblique.sh [STEPS_PER_CONTACT…]
# The normal force is cut at zero as Bedload's is (limit_damping). Cost: median loop time of REPEATS (5) runs.
set -euo pipefail
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
[ $# -gt 0 ] || set -- 10 20 50 100 200 500
cd "$work"
python3 - "$here/scenes/oblique-collision.toml" > start.data <<'P'
import sys, tomllib
grains = tomllib.load(open(sys.argv[1], "rb"))["grains"]
print(f"pairs\n\n{len(grains)} atoms\n1 atom types\n-0.01 0.01 xlo xhi\n-0.01 0.15 ylo yhi\n-0.01 0.01 zlo zhi\n\nAtoms\n")
for n, g in enumerate(grains, 1):
    print(n, 1, 2 * g["radius"], g["density"], *map(repr, g["position"]))
print("\nVelocities\n")
for n, g in enumerate(grains, 1):
    print(n, *map(repr, g["velocity"]), 0, 0, 0)
P
read -r kn kt gn tc < <(python3 -c "
import math
tc, e, m = 1e-5, 0.87, 1319 * 4 / 3 * math.pi * 0.0015**3 / 2
print(repr(m * (math.pi**2 + math.log(e)**2) / tc**2), repr(0.2 * m * (math.pi**2 + math.log(e)**2) / tc**2), repr(-2 * math.log(e) / tc), tc)")
for steps in "$@"; do
  cat > deck <<D
units si
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
read_data start.data
pair_style gran/hooke/history $kn $kt $gn 0.0 0.25 0 limit_damping
pair_coeff * *
neighbor 1e-4 bin
neigh_modify delay 0 every 1 check yes
timestep $(python3 -c "print(repr($tc / $steps))")
fix move all nve/sphere
thermo 1000000
run $((2 * steps))
write_dump all custom end.txt id vx vy vz omegax omegay omegaz modify sort id format float %.17g
D
  : > times
  for turn in $(seq "${REPEATS:-5}"); do
    OMP_NUM_THREADS=1 "${LMP:-lmp}" -in deck -log none > said
    sed -n 's/^Loop time of \([^ ]*\) .*/\1/p' said >> times
  done
  python3 - "$here" "$steps" <<'P'
import csv, statistics, sys
here, steps = sys.argv[1:]
rows = csv.DictReader(line for line in open(here + "/scenes/reference/oblique_linear_model.csv") if line[0] != "#")
exact = {float(r["psi1"]): float(r["psi2"]) for r in rows if r["kt_over_kn"] == "0.200000" and r["variant"] == "limited"}
grains = [list(map(float, line.split())) for line in open("end.txt").read().split("\n")[9:] if line]
radius, v_n, worst = 0.0015, 1e-3, 0.0
for (psi1, psi2), i, j in zip(sorted(exact.items()), grains[::2], grains[1::2]):
    slip = (i[3] - j[3] - radius * (i[5] + j[5])) / v_n
    worst = max(worst, abs(slip / psi2 - 1))
cost = statistics.median(float(line) for line in open("times"))
print(f'  {{ name = "LAMMPS, t_c/Δt = {steps}", cost = {cost:.3g}, error = {worst:.3g}, source = "tests/peers/oblique.sh" }},')
P
done
