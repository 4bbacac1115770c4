"""Runs, checks, and how they fail."""

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from conftest import SCENE

import bedload


def read_rows(folder):
    return Path(folder, "series.csv").read_text().splitlines()


def test_a_run_of_a_dictionary(finished):
    assert finished.summary["status"] == "completed"
    assert finished.summary["time"]["fluid_steps"] == 100
    assert 0.0 < finished.metrics["reynolds"] < 100.0
    assert repr(finished).endswith("completed, t = 2.0 s)")
    assert finished.scene["title"] == SCENE["title"]
    assert not list(Path(".").glob(".scene-*")), "the file of the scene is gone"


def test_a_run_of_a_file_with_other_values(scene):
    from bedload._scene import document

    Path("fall.toml").write_text(document(scene))
    run = bedload.run("fall.toml", set={"grains[0].density": 2.0}, until=0.1, threads=1, record=False)
    assert run.path == Path("out/fall")
    assert run.scene["grains"][0]["density"] == 2.0 and run.scene["until"] == 0.1
    assert not (run.path / "exchange.mcap").exists()
    with pytest.raises(bedload.BedloadError, match="record=False"):
        _ = run.log
    # A finished run is not lost.
    with pytest.raises(bedload.BedloadError, match="overwrite") as error:
        bedload.run("fall.toml", until=0.2)
    assert error.value.code == 2 and error.value.out == run.path
    assert bedload.run("fall.toml", until=0.2, overwrite=True).summary["time"]["simulated"] == 0.2


def test_a_wrong_key_is_bad_input(scene):
    scene["medium"]["viscosity"] = "thick"
    for command in (bedload.run, bedload.check):
        with pytest.raises(bedload.BedloadError, match="medium.viscosity") as error:
            command(scene)
        assert (error.value.code, error.value.kind) == (2, "bad-input")
        assert "docs/scene.md" in str(error.value)


def test_a_plan_and_one_that_breaks_a_bound(scene):
    plan = bedload.check(scene)
    assert plan["dt_fluid"] == 0.02 and plan["cells"] == 4000
    assert all(bound["holds"] for bound in plan["bounds"])
    with pytest.raises(bedload.BedloadError, match="cfl") as error:
        bedload.check(scene, set={"fluid.time.dt": 2.0})
    again = pickle.loads(pickle.dumps(error.value))
    assert (again.kind, again.plan) == ("bad-input", error.value.plan), (
        "it comes back from a process of a pool"
    )
    assert [bound["name"] for bound in error.value.plan["bounds"] if not bound["holds"]].count("cfl") == 1


def test_the_schema_takes_every_scene():
    jsonschema = pytest.importorskip("jsonschema")
    tomllib = pytest.importorskip("tomllib")
    root = Path(__file__).parents[3]
    check = jsonschema.Draft202012Validator(bedload.schema())
    scenes = [*root.glob("scenes/*.toml"), *root.glob("coupler/program/src/templates/*/*.toml")]
    assert len(scenes) > 30
    for scene in scenes:
        errors = [error.message for error in check.iter_errors(tomllib.loads(scene.read_text("utf-8")))]
        assert not errors, f"{scene}: {errors[0]}"
    wrong = {"until": 1.0, "domain": {"boundary": {"x": {"type": "no-slip", "speed": 1.0}}}}
    assert list(check.iter_errors(wrong))


def test_the_schema_names_the_keys():
    assert {"gravity", "domain", "grains", "medium"} <= set(bedload.schema()["properties"])


def test_a_dead_solver_is_said(scene):
    Path("dies.sh").write_text("#!/bin/sh\necho 'I am no solver' >&2\nexit 9\n")
    Path("dies.sh").chmod(0o755)
    scene["dem"]["command"] = ["./dies.sh"]
    with pytest.raises(bedload.BedloadError, match="I am no solver") as error:
        bedload.run(scene, "out")
    assert (error.value.code, error.value.kind) == (3, "solver-died")


def test_no_program_no_run(monkeypatch):
    monkeypatch.setenv("BEDLOAD_BIN", "/nowhere")
    with pytest.raises(bedload.BedloadError, match="BEDLOAD_BIN"):
        bedload.schema()


def test_ctrl_c_leaves_a_checkpoint_from_which_the_run_goes_on(scene):
    def press():
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline and not (
            Path("cut/series.csv").exists() and len(read_rows("cut")) > 50
        ):
            time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press, daemon=True).start()
    with pytest.raises(KeyboardInterrupt):
        bedload.run(scene, "cut", until=1e5, threads=1, record=False)
    cut = bedload.Run("cut")
    assert cut.summary["status"] == "interrupted"
    assert list(cut.path.glob("checkpoint/*/loop.checkpoint"))
    end = round(cut.summary["time"]["simulated"] + 0.5, 6)
    resumed = bedload.run(scene, "cut", until=end, threads=1, record=False, resume=True)
    bedload.run(scene, "whole", until=end, threads=1, record=False)
    assert resumed.summary["status"] == "completed"
    assert read_rows("cut")[:-1] == read_rows("whole")[:-1], "the same bits"


def test_a_run_ends_in_order_when_python_is_killed(scene):
    script = (
        "import bedload, conftest; bedload.run(conftest.SCENE, 'left', until=1e5, threads=1, record=False)"
    )
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    python = subprocess.Popen([sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": path})
    deadline = time.monotonic() + 60.0
    while not (Path("left/series.csv").exists() and len(read_rows("left")) > 2):
        assert python.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    python.kill()
    python.wait(10.0)
    while not Path("left/summary.json").exists():
        assert time.monotonic() < deadline, "the run goes on without anybody"
        time.sleep(0.05)
    assert bedload.Run("left").summary["status"] == "interrupted"


def test_progress_is_told_and_can_end_a_run(scene):
    class Enough(Exception):
        pass

    seen = []

    def told(progress):
        seen.append(progress)
        if progress.time > 0.0:
            raise Enough

    with pytest.raises(Enough):
        bedload.run(scene, "told", until=1e5, threads=1, record=False, progress=told)
    start, progress = seen
    assert (start.time, start.until, start.part) == (0.0, 1e5, 0.0)
    assert 0.0 < progress.time < progress.until == 1e5 and 0.0 < progress.part < 1.0
    assert bedload.Run("told").summary["status"] == "interrupted"


def test_progress_is_told_at_the_start_and_at_the_end_of_a_short_run(scene):
    seen = []
    bedload.run(scene, "short", set={"until": 0.1}, progress=seen.append)
    assert (seen[0].time, seen[0].until, seen[0].part) == (0.0, 0.1, 0.0)
    assert seen[-1].time == pytest.approx(0.1) and seen[-1].part == 1.0
    seen.clear()
    with pytest.raises(bedload.BedloadError):
        bedload.run("nothing.toml", "none", progress=seen.append)
    assert [(progress.until, progress.part) for progress in seen] == [(float("inf"), 0.0)]


def test_progress_prints(scene, capfd):
    bedload.run(scene, "printed", until=0.1, progress=True)
    assert "done, see printed" in capfd.readouterr().err


def test_a_replay_and_one_with_another_value(finished):
    log = finished.path / "exchange.mcap"
    assert bedload.replay(log, "dem", verify=True) is None
    table = bedload.replay(log, "dem", set={"gravity": [0.0, 0.0, -1.1]}, out="other")
    assert len(table["t"]) and max(table["position_m"] if "position_m" in table else table["position"]) > 0.0
    with pytest.raises(bedload.BedloadError) as error:
        bedload.replay("nothing.mcap", "dem")
    assert error.value.kind == "bad-input"


def test_a_study_makes_its_table(scene):
    from bedload._scene import document

    scene["until"] = 0.4
    scene["metrics"] = [
        {"name": "fall", "kind": "initial-acceleration", "reference": 0.6667, "source": "a test"}
    ]
    scene["chart"] = {
        "title": "A chart",
        "metric": "fall",
        "vary": [{"key": "fluid.time.dt", "name": "dt", "values": [0.01, 0.02]}],
    }
    Path("chart.toml").write_text(document(scene))
    out = bedload.study("chart.toml", out="study", jobs=1)
    assert (out / "chart.csv").is_file()


def has_ensembles():
    asked = subprocess.run([bedload.program(), "ensemble", "--help"], capture_output=True, check=False)
    return asked.returncode == 0


@pytest.mark.skipif(not has_ensembles(), reason="this build of bedload has no ensembles")
def test_an_ensemble_has_a_mean(scene):
    del scene["grains"]
    scene["until"] = 0.1
    scene["domain"] = {"geometry": "plane", "lower": [0.0, 0.0], "upper": [5.0, 8.0], "cells": [50, 80]}
    scene["domain"]["boundary"] = {"x": "periodic", "z": "no-slip"}
    region = {"lower": [0.0, 0.0, 2.0], "upper": [5.0, 0.0, 7.0]}
    scene["groups"] = [{"count": 3, **region, "radius": 0.5, "density": 4.0, "seed": 1}]
    del scene["metrics"]
    table = bedload.ensemble(scene, 2, jobs=1, out="ensemble")
    row = list(table["name"]).index("position_z[0]")
    assert table["runs"][row] == 2 and 2.0 < table["mean"][row] < 7.0 and 0.0 < table["standard_error"][row]


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"set": ["a=1"]}, "set: .*dict"),
        ({"until": "x"}, "until: 'x'.*finite"),
        ({"until": float("nan")}, "until: nan.*finite"),
        ({"record": "none"}, "record: 'none'"),
        ({"progress": 7}, "progress: 7"),
    ],
)
def test_values_of_another_type_are_named(scene, options, named):
    with pytest.raises(TypeError, match=named):
        bedload.run(scene, "typed", **options)
    assert not os.path.exists("typed")


def test_a_scene_is_a_path_or_a_dict():
    with pytest.raises(TypeError, match="scene: 3.*path"):
        bedload.run(3, "typed")
