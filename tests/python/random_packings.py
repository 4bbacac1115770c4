#!/usr/bin/env python3
"""Flow through random packings of spheres by grid, with nominal and with corrected mask radii.

    random_packings.py [--bedload-fluid target/release/bedload-fluid] [--draws 2] [--widths 8,10,12,16]

Centres are drawn at random in a periodic box (seeds 1, 2, ...; solid fractions 0.30 and 0.45 by turns), pushed apart
until they do not overlap, and held. A body force drives Stokes flow for 200 steps of nu dt/dx^2 = 1.7. Printed is the
superficial velocity, and its excess over that of the finest grid with the corrected radius.
"""

import argparse
import json
import math
import pathlib
import random
import subprocess
import tempfile

PACKINGS = ((0.30, 20), (0.45, 27))  # solid fraction, spheres


def pack(fraction, count, seed):
    """Box length and centres of spheres of diameter 1."""
    draw = random.Random(seed)
    length = (count * math.pi / 6 / fraction) ** (1 / 3)
    centres = [[draw.uniform(0, length) for _ in range(3)] for _ in range(count)]
    for _ in range(20_000):
        worst = 0.0
        for i in range(count):
            for j in range(i):
                apart = [a - b for a, b in zip(centres[i], centres[j])]
                apart = [d - length * round(d / length) for d in apart]
                distance = math.sqrt(sum(d * d for d in apart))
                overlap = 1.004 - distance
                if overlap > 0:
                    worst = max(worst, overlap)
                    for k in range(3):
                        push = 0.5 * overlap * apart[k] / distance
                        centres[i][k] += push
                        centres[j][k] -= push
        if worst < 0.003:
            return length, [[x % length for x in centre] for centre in centres]
    raise SystemExit(f"seed {seed}: no packing of {fraction} found; take another seed")


def scene(length, centres, cells, radius):
    dt = 1.7 * (length / cells) ** 2
    grains = "".join(
        f'[[grains]]\nposition = {centre}\nradius = 0.5\ndensity = 2.0\nmotion = "fixed"\n' for centre in centres
    )
    return f"""until = {200 * dt}
[domain]
geometry = "space"
lower = [0.0, 0.0, 0.0]
upper = [{length}, {length}, {length}]
cells = [{cells}, {cells}, {cells}]
boundary = {{ x = "periodic", y = "periodic", z = "periodic" }}
[medium]
density = 1.0
viscosity = 1.0
body_force = [0.0, 0.0, 1.0]
[fluid]
time = {{ dt = {dt}, convection = false }}
immersed = {{ mask_radius = "{radius}" }}
[observe]
every = {500 * dt}
grains = []
planes = {{ every = {20 * dt}, from = {170 * dt} }}
[[metrics]]
name = "superficial"
kind = "mean-fluid-velocity"
component = "z"
{grains}"""


def flow(program, text):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "packing.toml")
        file.write_text(text)
        out = pathlib.Path(folder, "out")
        command = [program, "run", str(file), "--out", str(out), "--threads", "1"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return json.loads((out / "summary.json").read_text())["metrics"]["superficial"]["value"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bedload-fluid", default="target/release/bedload-fluid")
    parser.add_argument("--draws", type=int, default=2)
    parser.add_argument("--widths", default="8,10,12,16")
    arguments = parser.parse_args()
    widths = [float(width) for width in arguments.widths.split(",")]
    for seed in range(1, arguments.draws + 1):
        fraction, count = PACKINGS[(seed - 1) % len(PACKINGS)]
        length, centres = pack(fraction, count, seed)
        rows = []
        for width in widths:
            cells = round(length * width)
            found = [flow(arguments.bedload_fluid, scene(length, centres, cells, r)) for r in ("nominal", "corrected")]
            rows.append((cells / length, found))
        limit = rows[-1][1][1]
        for width, found in rows:
            excess = ["%+.2f %%" % (100 * (u / limit - 1)) for u in found]
            print(f"seed {seed}, solid fraction {fraction}, D/dx {width:.2f}: nominal {found[0]:.6g} ({excess[0]}), "
                  f"corrected {found[1]:.6g} ({excess[1]})", flush=True)


if __name__ == "__main__":
    main()
