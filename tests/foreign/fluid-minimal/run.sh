#!/usr/bin/env bash
# Builds the fluid and checks it with Bedload's coupler and DEM; exit 1 if a check fails.
#   cargo build --release
#   tests/foreign/fluid-minimal/run.sh [BINARIES [BUILD_FOLDER]]
# BINARIES: the folder of bedload and bedload-dem, by default target/release.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bedload=$(cd "${1:-${CARGO_TARGET_DIR:-$here/../../../target}/release}" && pwd)/bedload
fluid=$("$here/build.sh" "${@:2:1}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
scene=$here/settling-stokes.toml failed=0

check() { # NAME COMMAND...
  local name=$1 begin=$SECONDS
  shift
  echo "$name"
  if "$@"; then echo "  pass, $((SECONDS - begin)) s"; else echo "  FAIL"; failed=1; fi
}
run() { # DIR OPTION...: the scene with this fluid
  "$bedload" run "$scene" --set "fluid.command=[\"$fluid\"]" --out "$work/$1" "${@:2}" > "$work/log" 2>&1 ||
    { cat "$work/log"; return 1; }
}
refuses() { # CODE WORD COMMAND...: ends with this code, saying the word
  local code=0
  "${@:3}" > "$work/log" 2>&1 || code=$?
  grep -F -m 1 -e "$2" "$work/log" && [ "$code" = "$1" ]
}
settles() { # SCHEME
  local scheme=$1 n dirs=()
  for n in 8 16 32; do
    run "$scheme-$n" --set "coupling.scheme=\"$scheme\"" --set "fluid.time.dt=$(python3 -c "print(1 / 16 / $n)")" || return 1
    dirs+=("$work/$scheme-$n")
  done
  python3 "$here/check.py" settles "$scheme" "${dirs[@]}"
}
resumes() { # SCHEME: to the half and on, beside the whole
  run "$1-cut" --set "coupling.scheme=\"$1\"" --until 0.15625 &&
    run "$1-cut" --set "coupling.scheme=\"$1\"" --resume &&
    python3 "$here/check.py" same "$work/$1-8" "$work/$1-cut"
}
orphaned() { # the coupler is killed: the fluid leaves, and no segment of the run stays behind
  local coupler child='' prefix left=1 n
  "$bedload" run "$scene" --set "fluid.command=[\"$fluid\"]" --until 3906.25 --out "$work/orphaned" > "$work/log" 2>&1 &
  coupler=$!
  for n in $(seq 100); do
    sleep 0.05
    child=$(pgrep -P "$coupler" -x fluid-minimal) && [ -n "$(find "$work/orphaned" -name exchange.mcap -size +64k)" ] && break
  done
  prefix=$(tr '\0' '\n' < "/proc/$child/cmdline" | sed -n 's/.*"prefix":"\([^"]*\)".*/\1/p')
  kill -9 "$coupler"
  wait "$coupler" 2> /dev/null || true
  for n in $(seq 100); do
    left=$(find /dev/shm -maxdepth 1 -name "$prefix*" | wc -l)
    [ "$left" = 0 ] && break
    sleep 0.05
  done
  echo "  $left segments of run $prefix are left"
  [ -n "$prefix" ] && [ "$left" = 0 ]
}
facts() { "$fluid" check "$scene" --json | python3 "$here/check.py" facts 0.0078125; }
damaged() { # half of a checkpoint is refused
  run damaged --until 0.15625 || return 1
  truncate -s 50 "$work"/damaged/checkpoint/*/fluid.checkpoint
  refuses 2 'fluid.checkpoint is no checkpoint of 1 grains' \
    "$bedload" run "$scene" --set "fluid.command=[\"$fluid\"]" --out "$work/damaged" --resume
}

check "conformance, built-in scene" "$bedload" conformance --role fluid -- "$fluid"
check "conformance, settling-stokes.toml" "$bedload" conformance --role fluid --scene "$scene" -- "$fluid"
check "facts" facts
for scheme in semi-implicit iterated; do
  check "settling, $scheme" settles "$scheme"
  check "resume, $scheme" resumes "$scheme"
done
check "the DEM does the same again from the log" "$bedload" replay "$work/semi-implicit-8/exchange.mcap" --drive dem --verify
check "the coupler is killed" orphaned
check "a step that is too long is refused" refuses 2 explicit-drag \
  "$bedload" check "$scene" --allow-commands --set "fluid.command=[\"$fluid\"]" --set fluid.time.dt=0.046875
check "a flow is refused" refuses 2 medium.body_force \
  "$bedload" check "$scene" --allow-commands --set "fluid.command=[\"$fluid\"]" --set 'medium.body_force=[1.0, 0.0, 0.0]'
check "a damaged checkpoint is refused" damaged
exit $failed
