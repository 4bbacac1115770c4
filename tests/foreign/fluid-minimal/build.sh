#!/usr/bin/env bash
# Builds the fluid: tests/foreign/fluid-minimal/build.sh [BUILD_FOLDER]
# The program is BUILD_FOLDER/fluid-minimal; by default target/foreign/fluid-minimal/fluid-minimal.
# Needs cargo, and gcc or clang (CC). iceoryx2 is that of Cargo.lock, from crates.io.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../../..
build=${1:-${CARGO_TARGET_DIR:-$root/target}/foreign/fluid-minimal}
mkdir -p "$build/door"
build=$(cd "$build" && pwd)
version=$(awk '$0 == "name = \"iceoryx2\"" { getline; gsub(/[^0-9.]/, ""); print }' "$root/Cargo.lock")
grep -qF "iceoryx2 = \"=$version\"" "$here/door/Cargo.toml" || {
  echo "Cargo.lock has iceoryx2 $version: door/Cargo.toml must name the same" >&2
  exit 1
}
# Built beside the sources, with the lock of the repository: every dependency is of the version it has there.
cp "$here/door/Cargo.toml" "$here/door/lib.rs" "$build/door/"
cp "$root/Cargo.lock" "$build/door/"
cargo build --quiet --release --manifest-path "$build/door/Cargo.toml" --target-dir "$build/door/target"
"${CC:-gcc}" -std=c11 -O2 -Wall -Wextra -I"$here/door" -o "$build/fluid-minimal" "$here"/{main,link,scene}.c \
  "$build/door/target/release/libiceoryx_door.a" -lpthread -ldl -lm
echo "$build/fluid-minimal"
