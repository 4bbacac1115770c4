# Sourced by run.sh of a DEM in Python, after `here` is set: bedload, python, work, and check, ours, theirs, resumes.
root=$here/../../..
bedload=$(cd "${1:-${CARGO_TARGET_DIR:-$root/target}/release}" && pwd)/bedload
python=$("$here/../python/install.sh")
command=("$python" "$here/dem.py")
[ ! -x "$here/dem.sh" ] || command=("$here/dem.sh")
dem="dem.command=[$(printf '"%s", ' "${command[@]}")]"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

check() { # NAME COMMAND...
  local name=$1 begin=$SECONDS
  shift
  echo "$name"
  if "$@"; then echo "  pass, $((SECONDS - begin)) s"; else echo "  FAIL"; failed=1; fi
}
run() { "$bedload" run "$@" > "$work/log" 2>&1 || { cat "$work/log"; return 1; }; }
both() { # NAME SCENE OPTION...: with our DEM and with this one
  run "$2" --out "$work/$1-ours" "${@:3}" && run "$2" --out "$work/$1-theirs" --set "$dem" "${@:3}"
}
compared() { "$python" "$here/../python/compare.py" "$work/$1-ours" "$work/$1-theirs" "${@:2}"; }
resumes() { # SCENE UNTIL OPTION...: cut at half and gone on with, beside the whole
  run "$1" --out "$work/whole" --set "$dem" --until "$2" "${@:3}" &&
    run "$1" --out "$work/cut" --set "$dem" --until "$(python3 -c "print($2 / 2)")" "${@:3}" &&
    run "$1" --out "$work/cut" --set "$dem" --until "$2" --resume "${@:3}" &&
    cmp "$work/whole/series.csv" "$work/cut/series.csv" && echo "  the same bits"
}
