"""A DEM of one's own in a few lines, in coupled runs."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bedload

pytest.importorskip("iceoryx2")

SPRINGS = '''
import math
import numpy as np
from bedload.solver import Dem, start


class Springs(Dem):
    """Normal springs and dashpots of the scene (Izard et al. 2014, eqs 17 and 18)."""

    def contact(self, h):
        force = np.zeros_like(self.x)
        log_e = math.log(self.law["restitution"])
        for who, _, n, gap in self.gaps(0.0):
            mass, signs = 1 / (1 / self.m[who]).sum(), np.array([1, -1])[: len(who)]
            k, c = mass * (math.pi**2 + log_e**2) / self.t_c**2, -2 * mass * log_e / self.t_c
            push = max(0.0, -k * gap - c * (signs @ self.v[who]) @ n)
            force[who] += np.outer(signs, push * n)
        return force, np.zeros_like(force)


start(Springs)
'''


@pytest.fixture
def springs():
    Path("springs.py").write_text(SPRINGS)
    return [sys.executable, str(Path("springs.py").absolute())]


def test_it_falls_as_ours_does(scene, springs):
    scene["until"], scene["dem"]["lubrication"] = 3.5, {"form": "none"}
    scene["dem"]["contact"]["form"] = "izard-2014"
    scene["grains"][0]["position"][2] = 1.2
    ours = bedload.run(scene, "ours", threads=1)
    theirs = bedload.run(scene, "theirs", threads=1, set={"dem.command": springs})
    assert theirs.summary["status"] == "completed"
    a, b = (np.asarray(run.series["position_z[0]"]) for run in (ours, theirs))
    touches = np.asarray(theirs.series["contact_force_z[0]"]) > 0.0
    assert a.min() < 0.51 and touches.any(), "it has reached the floor"
    # In flight the same but for the round-off of sub-steps; in contact ours takes the moment of the first
    # touch into account, and this one does not.
    assert np.abs(a - b)[: touches.argmax()].max() < 1e-5
    assert np.abs(a - b).max() < 5e-3


def test_it_goes_on_from_its_checkpoint(scene, springs):
    scene["dem"]["lubrication"], scene["dem"]["command"] = {"form": "none"}, springs
    # Whole windows end at 0.5: none is cut to fit.
    scene["fluid"]["time"]["dt"] = 0.03125
    bedload.run(scene, "whole", threads=1, until=1.0)
    bedload.run(scene, "cut", threads=1, until=0.5)
    bedload.run(scene, "cut", threads=1, until=1.0, resume=True)
    assert Path("cut/series.csv").read_bytes() == Path("whole/series.csv").read_bytes()


def test_it_refuses_what_it_does_not_know(scene, springs):
    scene["grains"].append({**scene["grains"][0], "position": [0.0, 0.0, 6.0], "motion": "fixed"})
    scene["dem"]["command"] = springs
    with pytest.raises(bedload.BedloadError, match="not for this DEM") as error:
        bedload.check(scene, allow_commands=True)
    assert error.value.kind == "bad-input"


def test_it_conforms_to_the_protocol(springs):
    words = [
        bedload.program(),
        "conformance",
        "--role",
        "dem",
        "--set",
        'dem.lubrication={ form = "none" }',
        "--",
    ]
    asked = subprocess.run([*words, *springs], capture_output=True, text=True, timeout=300, check=False)
    assert asked.returncode == 0, asked.stdout + asked.stderr


def test_one_row_for_all_grains_is_refused(scene):
    one = SPRINGS.replace("return force, np", "return force[:1], np")
    Path("one.py").write_text(one)
    scene["grains"].append({**scene["grains"][0], "position": [0.0, 0.0, 6.0]})
    scene["dem"]["lubrication"] = {"form": "none"}
    scene["dem"]["command"] = [sys.executable, str(Path("one.py").absolute())]
    with pytest.raises(bedload.BedloadError, match="a row a grain"):
        bedload.run(scene, "one", threads=1)


def test_it_says_how_it_is_started(springs):
    asked = subprocess.run(springs, capture_output=True, text=True, timeout=60, check=False)
    assert asked.returncode == 2 and "bedload" in asked.stderr
