"""What the detector of instability (coupling.force "unstable") ends, and whether it is right.

    python3 tests/python/detector.py --out out/detector [--jobs 2] beds --count 100 --seed 1
    python3 tests/python/detector.py --out out/detector [--jobs 2] maps light-bed light-wall

`beds`: scenes with many grains, each drawn from the seed and its number alone: discs or spheres, sheared, settling or
neutral; solid fraction, density ratio, viscosity, contacts, resolution and time step. A run that ends as unstable is
made again with the detector off: where that one ends well, the alarm was false.

`maps`: the runs of maps of stability with all other bounds off, beside the verdicts of docs/maps.
"""

import argparse
import collections
import csv
import itertools
import json
import math
import random
import re
import subprocess
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

UNSTABLE = 4


def scene(seed, number):
    """The text of a drawn scene: units D = rho = 1."""
    draw = random.Random(f"{seed}/{number}")
    space = number % 5 >= 3
    kind = draw.choice(["sheared", "settling", "neutral", "dense"])
    cells = draw.choice([6, 8, 10] if not space else [6, 8])
    box = [draw.choice([8, 10, 12]), draw.choice([6, 8])] if not space else [4, 4, draw.choice([4, 5])]
    solid = {"sheared": (0.2, 0.4), "settling": (0.05, 0.3), "neutral": (0.1, 0.35), "dense": (0.3, 0.42)}[kind]
    fraction = draw.uniform(*solid) * (0.75 if space else 1.0)
    volume = math.prod(box)
    one = math.pi / 6 if space else math.pi / 4
    count = max(4, int(fraction * volume / one))
    density = 1.0 if kind == "neutral" else 1.0 + 10 ** draw.uniform(-1.3, 0.4)
    gravity = 0.0 if kind == "neutral" else 1.0 / (density - 1.0)
    galileo = 10 ** draw.uniform(0.0, 1.8)
    lid = draw.uniform(0.5, 6.0) if kind in ("sheared", "neutral") else 0.0
    viscosity = 1.0 / galileo if kind != "neutral" else lid / 10 ** draw.uniform(0.0, 1.5)
    speed = max(lid, 1.0)
    restitution, friction = draw.choice([0.2, 0.5, 0.8, 0.97]), draw.choice([0.0, 0.3, 0.5])
    contact = 10 ** draw.uniform(-2.7, -0.9) / speed
    axes = "xyz" if space else "xz"
    periodic = "\n".join(f'{axis} = "periodic"' for axis in axes[:-1])
    top = f'{{ type = "no-slip", velocity = [{lid}, 0.0, 0.0] }}'
    upper, lower = [float(length) for length in box], [0.0] * len(box)
    region = [*box[:-1], box[-1]]
    corner = lambda values: values if space else [values[0], 0.0, values[1]]
    return f"""until = {draw.uniform(15.0, 40.0) / speed}
gravity = [0.0, 0.0, {-gravity}]
[domain]
geometry = "{'space' if space else 'plane'}"
lower = {lower}
upper = {upper}
cells = {[cells * length for length in box]}
[domain.boundary]
{periodic}
z_lower = "no-slip"
z_upper = {top}
[medium]
density = 1.0
viscosity = {viscosity}
[[groups]]
count = {count}
lower = {corner([0.0] * (len(box) - 1) + [0.05])}
upper = {corner([float(length) for length in region[:-1]] + [region[-1] - 0.05])}
radius = 0.5
density = {density}
seed = {number}
[fluid.time]
scheme = "{draw.choice(['rk3', 'ab2'])}"
cfl = {draw.choice([0.3, 0.4, 0.5])}
[dem]
steps_per_contact = 60
[dem.contact]
law = "linear-spring-dashpot"
restitution = {restitution}
contact_time = {contact}
friction = {friction}
[observe]
grains = {list(range(count))}
"""


def run(binary, file, out, more):
    command = [binary, "run", str(file), "--threads", "1", "--no-record", "--overwrite", "--out", str(out), *more]
    done = subprocess.run(command, capture_output=True, text=True)
    out.with_suffix(".err").write_text(done.stderr)
    return done.returncode, done.stderr.strip().splitlines()[-1:] or [""]


def judge(binary, out, seed, number):
    file = out / f"{number}.toml"
    file.write_text(scene(seed, number))
    code, last = run(binary, file, out / str(number), [])
    forced, fault = 0, [""]
    if code == UNSTABLE:
        forced, fault = run(binary, file, out / f"{number}-forced", ["--set", 'coupling.force=["unstable"]'])
    said = last[0][:300] if code else ""
    return {"number": number, "code": code, "last": said, "forced": forced, "fault": fault[0][:200]}


def beds(asked):
    numbers = range(asked.first, asked.first + asked.count)
    with ThreadPoolExecutor(asked.jobs) as pool:
        for result in pool.map(lambda n: judge(asked.binary, asked.out, asked.seed, n), numbers):
            print(json.dumps(result), flush=True)


def runs_of(name):
    """Settings of the runs of a map, with the verdict that docs/maps has of each."""
    scene = Path(f"scenes/stability/{name}.toml")
    varied = tomllib.loads(scene.read_text())["stability"]["vary"]
    with open(f"docs/maps/{name}.csv", newline="") as table:
        rows = list(csv.DictReader(table))
    options = []
    for vary in varied:
        of = lambda value: value["set"] if isinstance(value, dict) else {vary["key"]: value}
        options.append([of(value) for value in vary["values"]])
    products = list(itertools.product(*options))
    assert len(products) == len(rows), f"{name}: {len(products)} runs, {len(rows)} rows"
    for settings, row in zip(products, rows):
        merged = {key: value for setting in settings for key, value in setting.items()}
        yield scene, [f"{key}={json.dumps(value)}" for key, value in merged.items()], row


def maps(asked):
    names = re.findall(r'^ *"([a-z0-9-]+)",$', Path("coupler/src/bounds/names.rs").read_text(), re.MULTILINE)
    names += re.findall(r'const [A-Z_]+: &str = "([a-z0-9-]+)"', Path("coupler/src/bounds/names.rs").read_text())
    forced = "coupling.force=" + json.dumps(sorted(set(names) - {"unstable"}))

    def one(number, scene, settings, row):
        more = [part for setting in [*settings, forced] for part in ("--set", setting)]
        code, last = run(asked.binary, scene, asked.out / f"{scene.stem}-{number}", more)
        return row["verdict"], code, row["label"], last[0]

    for name in asked.names:
        with ThreadPoolExecutor(asked.jobs) as pool:
            done = list(pool.map(lambda job: one(job[0], *job[1]), enumerate(runs_of(name))))
        counts = collections.Counter((verdict, code) for verdict, code, _, _ in done)
        for (verdict, code), count in sorted(counts.items()):
            print(json.dumps({"map": name, "verdict": verdict, "code": code, "runs": count}), flush=True)
        for verdict, code, label, last in done:
            if (verdict == "stable") != (code == 0):
                print(json.dumps({"map": name, "verdict": verdict, "code": code, "label": label, "last": last[:200]}), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--binary", default="target/release/bedload")
    parser.add_argument("--out", type=Path, required=True)
    commands = parser.add_subparsers(dest="command", required=True)
    of_beds = commands.add_parser("beds")
    of_beds.add_argument("--count", type=int, default=100)
    of_beds.add_argument("--first", type=int, default=0)
    of_beds.add_argument("--seed", type=int, default=1)
    commands.add_parser("maps").add_argument("names", nargs="+")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    beds(asked) if asked.command == "beds" else maps(asked)


if __name__ == "__main__":
    main()
