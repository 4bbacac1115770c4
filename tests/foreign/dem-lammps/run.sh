#!/usr/bin/env bash
# Checks LAMMPS with Bedload's coupler and fluid, and compares it with Bedload's DEM; exit 1 if a check fails.
#   cargo build --release
#   tests/foreign/dem-lammps/run.sh [BINARIES]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../python/checks.sh"

# Elastic: the virtual mass in a contact of LAMMPS is that of a sphere far from the wall.
bounce() {
  both bounce "$root/scenes/bouncing-sphere-izard.toml" --until 0.45 --no-record --set dem.contact.restitution=1.0 --set 'dem.lubrication={ form = "none" }' &&
    compared bounce impact_velocity_ratio=1e-3 rebound_velocity_ratio=1e-3 rebound_height_over_diameter=1e-3
}
settling() { # allowed: about three times how far our own runs differ when density or end change a little
  both settling "$here/../settling-200.toml" --no-record &&
    compared settling kinetic_energy@4=2e-3 kinetic_energy@8=1e-2 height@24=1e-2
}

check "conformance" "$bedload" conformance --role dem --physics --set 'dem.lubrication={ form = "none" }' -- "${command[@]}"
check "bounce, no film" bounce
check "200 spheres settle" settling
check "resume from LAMMPS's restart file" resumes "$here/../settling-200.toml" 4 --set 'fluid.time={ scheme = "ab2", dt = 0.0625 }'
exit $failed
