#!/usr/bin/env python3
"""Do two builds give the same bits?

    tests/python/same_bits.py --out TABLE.csv [--bin target/release] [--only WORD] [--threads 1,2] [--jobs 2]
    tests/python/same_bits.py --compare OLD.csv NEW.csv

Run in the root of a checkout. Every quick run of the validation cases and the scenes in EXTRA is made on each number of
threads. A row has the SHA-256 (16 digits) of `series.csv` and of the states in the last checkpoint; the identity of the
scene, which stands before a state, is left out, so that a renamed key changes nothing. Python's standard library only.
"""

import argparse
import concurrent.futures
import csv
import hashlib
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import tomllib

COLUMNS = ["run", "threads", "series", "fluid", "dem"]

# name: scene, overrides
EXTRA = {
    "inclined-bed": ("scenes/inclined-bed.toml", ["until=1.0"]),
    "spheres-200": ("scenes/bench/spheres-200.toml", []),
    "packing-8000": ("scenes/bench/packing-8000.toml", []),
    "collapse-2d": ("scenes/collapse-2d.toml", ["until=1.7", "groups[0].count=300"]),
    "couette-erosion": ("scenes/couette-erosion.toml", ["until=5.0"]),
}


def quick_runs():
    """Name, scene and overrides of the quick runs of the quick cases."""
    for path in sorted(pathlib.Path("scenes/validation").glob("*.toml")):
        case = tomllib.loads(path.read_text())["case"]
        for run in case["runs"] if case.get("quick") else []:
            if run.get("quick"):
                yield f"{case['name']}/{run['label']}", path.parent / run["scene"], run.get("set", [])


def digest(data):
    return hashlib.sha256(data).hexdigest()[:16]


def state(folder, role):
    """Digest of the state in the last checkpoint: magic, version, length and digest (56 bytes), identity, state."""
    paths = sorted(folder.rglob(f"{role}.checkpoint"))
    if not paths:
        return "-"
    data = paths[-1].read_bytes()
    (length,) = struct.unpack_from("<Q", data, 56)
    return digest(data[64 + length :])


def row(task):
    name, scene, overrides, threads, programs = task
    out = pathlib.Path(tempfile.mkdtemp(prefix="same-bits-"))
    command = [f"{programs}/bedload", "run", str(scene), "--threads", str(threads), "--out", str(out / "run")]
    for override in overrides:
        command += ["--set", override]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        print(f"{name}: code {done.returncode}: {done.stderr[-400:]}", file=sys.stderr)
    series = out / "run" / "series.csv"
    checkpoint = out / "run" / "checkpoint"
    found = [
        digest(series.read_bytes()) if series.exists() else "-",
        state(checkpoint, "fluid"),
        state(checkpoint, "dem"),
    ]
    shutil.rmtree(out)
    print(name, threads, *found, flush=True)
    return [name, threads, *found]


def compare(old, new):
    """Rows of both tables that differ, and how many agree."""
    old, new = ({(r["run"], r["threads"]): r for r in csv.DictReader(open(path))} for path in (old, new))
    shared = [key for key in new if key in old]
    differ = [key for key in shared if old[key] != new[key]]
    for key in differ:
        parts = [name for name in COLUMNS[2:] if old[key][name] != new[key][name]]
        print(f"{key[0]} on {key[1]} threads: {', '.join(parts)} differ")
    print(f"{len(shared) - len(differ)} of {len(shared)} runs agree; {len(old) - len(shared)} were not made anew")
    return 1 if differ or not shared else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default="target/release")
    parser.add_argument("--out")
    parser.add_argument("--only", default="", help="names that contain this")
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--compare", nargs=2, metavar=("OLD", "NEW"))
    options = parser.parse_args()
    if options.compare:
        return compare(*options.compare)
    runs = list(quick_runs()) + [(name, *what) for name, what in EXTRA.items()]
    threads = [int(count) for count in options.threads.split(",")]
    tasks = [(*run, t, options.bin) for t in threads for run in runs if options.only in run[0]]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        rows = list(pool.map(row, tasks))
    with open(options.out, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
