# %% [markdown]
# # A bed under shear
# Discs fall into a bed, dry. Then a fluid covers them, whose lid moves: how much do they carry along?
# Units as in scenes/couette-erosion.toml: diameter, density of the fluid and reduced gravity are 1.

# %%
import numpy as np

import bedload

LENGTH, HEIGHT = 10.0, 6.0
contact = {"law": "linear-spring-dashpot", "restitution": 0.5, "contact_time": 4e-3, "friction": 0.3}

# %%
settling = {
    "until": 60.0,
    "gravity": [0.0, 0.0, -1.0],
    "stop_when": {"kinetic_energy_per_grain_below": 1e-8, "after": 5.0},
    "domain": {
        "geometry": "plane", "lower": [0.0, 0.0], "upper": [LENGTH, 12.0],
        "boundary": {"x": "periodic", "z_lower": "no-slip", "z_upper": "free-slip"},
    },
    "groups": [{"count": 24, "lower": [0.0, 0.0, 0.5], "upper": [LENGTH, 0.0, 8.0], "radius": 0.5,
                "radius_spread": 0.05, "density": 1.1, "seed": 1}],
    "dem": {"contact": contact},
    "observe": {"every": 0.5, "grains": []},
}
bed = bedload.run(settling, "out/bed", overwrite=True)
top = max(np.asarray(bed.table("grains.csv")["z"]))
print(f"{bed}: the highest centre lies at z = {top:.2f}")

# %%
shear = {
    "until": 16.0,
    "gravity": [0.0, 0.0, -10.0],
    "domain": {
        "geometry": "plane", "lower": [0.0, 0.0], "upper": [LENGTH, HEIGHT], "cells": [100, 60],
        "boundary": {"x": "periodic", "z_lower": "no-slip",
                     "z_upper": {"type": "no-slip", "velocity": [4.0, 0.0, 0.0]}},
    },
    "medium": {"density": 1.0, "viscosity": 0.70710678},
    "grain_files": [{"file": "out/bed/grains.csv"}],
    "fluid": {"time": {"cfl": 0.5}},
    "dem": {"steps_per_contact": 20, "contact": contact},
    "observe": {"every": 0.25, "grains": []},
}
run = bedload.run(shear, "out/sheared-bed", overwrite=True, progress=True)
print(run)

# %% [markdown]
# The flux of the grains per width, Σ V_p u_p / L, from the log, which has every grain in every window.

# %%
area = np.pi * np.asarray(bed.table("grains.csv")["radius"]) ** 2
time, flux = np.array([
    (message.head["header.time"] + message.head["header.dt"], area @ message.grains["velocity"][:, 0] / LENGTH)
    for message in run.log.messages("kinematics")
]).T
for end in range(2, 17, 2):
    part = (time > end - 2) & (time <= end)
    print(f"t = {end - 2:2} to {end:2}: flux {flux[part].mean():.4f}")
assert flux[time > 8].mean() > 0.0
