#!/usr/bin/env bash
# Checks the DEM in Python with Bedload's coupler and fluid, and compares it with Bedload's DEM; exit 1 if a check fails.
#   cargo build --release
#   tests/foreign/dem-python/run.sh [BINARIES]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../python/checks.sh"

bounce() { # FILM: velocity of impact and of rebound, over the largest; rebound height
  both "$1" "$root/scenes/bouncing-sphere-izard.toml" --until 0.45 --no-record --set "dem.lubrication=$2" &&
    compared "$1" impact_velocity_ratio=1e-3 rebound_velocity_ratio=1e-3 rebound_height_over_diameter=1e-3
}

check "conformance" "$bedload" conformance --role dem --physics --set 'dem.lubrication={ form = "none" }' -- "${command[@]}"
check "bounce, no film" bounce none '{ form = "none" }'
check "bounce, film as printed" bounce printed '{ form = "as-printed", roughness = 4e-4, cut_off = 0.5 }'
check "bounce, the film that the grid leaves" bounce complement '{ form = "complement", roughness = 4e-4, cut_off = 0.8 }'
check "resume" resumes "$here/../settling-200.toml" 0.5 --set 'fluid.time={ scheme = "ab2", dt = 0.0625 }'
exit $failed
