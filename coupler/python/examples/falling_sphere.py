# %% [markdown]
# # Falling spheres and the drag law
# A sphere is let go in a viscous fluid, in r–z on ten cells across. Where it falls steadily its drag bears its
# weight: C_D Re² = 4/3 Ar. The drag law is that of Clift, Grace & Weber (1978, table 5.2).
# Units: diameter, gravity and density of the fluid are 1; the sphere is four times as dense.

# %%
import math

import bedload


def clift(re):
    """Drag coefficient of a sphere by the Reynolds number, 0.01 to 260."""
    if re <= 20.0:
        return 24.0 / re * (1.0 + 0.1315 * re ** (0.82 - 0.05 * math.log10(re)))
    return 24.0 / re * (1.0 + 0.1935 * re**0.6305)


def expected(archimedes):
    """The Reynolds number at which the drag bears the weight, by bisection."""
    low, high = 0.01, 260.0
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if clift(middle) * middle**2 < 4 / 3 * archimedes else (low, middle)
    return low


# %%
scene = {
    "until": 12.0,
    "gravity": [0.0, 0.0, -1.0],
    "domain": {
        "geometry": "axisymmetric",
        "lower": [0.0, 0.0],
        "upper": [10.0, 36.0],
        "cells": [64, 360],
        "stretching": {"axis": "r", "uniform_to": 1.5, "spacing": 0.1},
        "boundary": {"r_upper": "free-slip", "z": "free-slip"},
    },
    "medium": {"density": 1.0, "viscosity": 1.0},
    "grains": [{"position": [0.0, 0.0, 33.0], "radius": 0.5, "density": 4.0}],
    "observe": {"every": 0.05, "fields_at": [12.0]},
    "metrics": [{"name": "reynolds", "kind": "terminal-reynolds"}],
}

# %%
print(f"{'Ar':>6} {'Re':>8} {'Clift':>8} {'error':>7}")
for archimedes in (100.0, 300.0, 800.0, 3000.0):
    viscosity = math.sqrt(3.0 / archimedes)
    run = bedload.run(scene, f"out/ar-{archimedes:g}", set={"medium.viscosity": viscosity}, overwrite=True)
    reynolds, law = run.metrics["reynolds"], expected(archimedes)
    print(f"{archimedes:6g} {reynolds:8.2f} {law:8.2f} {reynolds / law - 1:+7.1%}")
    assert abs(reynolds / law - 1) < 0.05

# %% [markdown]
# The flow of the last one, and how it has sped up. Without Matplotlib the figures are left out.

# %%
velocity, grid = run.field("velocity"), run.grid
print(f"largest velocity of the fluid at t = {velocity.time:g}: {-velocity[..., 2].min():.3f}, of the sphere "
      f"{-run.grains()['velocity'][0, 2]:.3f}")
try:
    import matplotlib.pyplot as plt
except ImportError:
    pass
else:
    figure, (left, right) = plt.subplots(1, 2)
    series = run.series
    left.plot(series["t"], series["velocity_z[0]"])
    left.set(xlabel="t", ylabel="velocity")
    right.pcolormesh(grid.faces["x"], grid.faces["z"], velocity[..., 2].T)
    right.set(xlim=(0, 3), aspect="equal", xlabel="r", ylabel="z")
    figure.savefig("out/falling-sphere.png")
