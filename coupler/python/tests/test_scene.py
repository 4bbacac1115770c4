"""Dictionaries as TOML."""

import math

import numpy as np
import pytest

import bedload
from bedload import _scene

VALUES = {
    "text": 'two "words",\na tab\t, a \\ and ρ \x7f',
    "whole": 3,
    "part": 0.1,
    "small": 1e-300,
    "big": 1e22,
    "open": math.inf,
    "yes": True,
    "list": [1.0, 2.0],
    "mixed": [{"a": 1}, {"b": [True]}],
    "table": {"inner": {"x.y": "dotted"}, "none": [], "": "no name"},
    "with space": 1,
}


def test_what_is_written_reads_back(tmp_path):
    (tmp_path / "scene.toml").write_text(_scene.document(VALUES), encoding="utf-8")
    assert _scene.read(tmp_path / "scene.toml") == VALUES


def test_numbers_of_numpy_count():
    assert _scene.inline(np.float64(0.1)) == "0.1"
    assert _scene.inline(np.array([[1, 2]])) == "[[1, 2]]"
    assert _scene.inline(np.bool_(True)) == "true"


def test_what_toml_has_not_is_refused_with_its_key():
    with pytest.raises(TypeError, match=r"grains\[0\]\.radius: .*None"):
        _scene.document({"grains": [{"radius": None}]})


def test_overrides_are_toml():
    words = _scene.settings({"fluid.time": {"scheme": "ab2", "dt": 0.5}, "coupling.force": ["cfl"]})
    assert words == ["--set", 'fluid.time={ scheme = "ab2", dt = 0.5 }', "--set", 'coupling.force=["cfl"]']


def test_a_dictionary_needs_a_folder_to_write_in(monkeypatch):
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(bedload.BedloadError, match="cannot write here.*remedy"), _scene.file_of({"until": 1.0}):
        pass
