"""A small run that many tests read."""

import os
import signal

import pytest

import bedload

# A shell that started the tests in the background has Ctrl-C ignored in them and in all that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

#: A sphere falls in a viscous fluid onto a floor; 4000 cells, 0.2 s of wall time for 100 windows.
SCENE = {
    "title": 'A sphere "falls"',
    "until": 2.0,
    "gravity": [0.0, 0.0, -1.0],
    "domain": {
        "geometry": "axisymmetric",
        "lower": [0.0, 0.0],
        "upper": [5.0, 8.0],
        "cells": [50, 80],
        "boundary": {"r_upper": "free-slip", "z_lower": "no-slip", "z_upper": "free-slip"},
    },
    "medium": {"density": 1.0, "viscosity": 0.06},
    "grains": [{"position": [0.0, 0.0, 3.0], "radius": 0.5, "density": 4.0}],
    "fluid": {"time": {"dt": 0.02}},
    "dem": {"contact": {"law": "linear-spring-dashpot", "restitution": 0.9, "contact_time": 1e-2}},
    "observe": {"fields_every": 0.5},
    "metrics": [{"name": "reynolds", "kind": "terminal-reynolds", "reference": 19.63, "source": "a test"}],
}


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def scene():
    import copy

    return copy.deepcopy(SCENE)


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """A finished run."""
    here, folder = os.getcwd(), tmp_path_factory.mktemp("finished")
    os.chdir(folder)
    try:
        return bedload.run(SCENE, folder / "run", threads=1)
    finally:
        os.chdir(here)
