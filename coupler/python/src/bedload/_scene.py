"""Scenes as dictionaries: written as TOML, and read."""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Union

from ._program import BedloadError

if sys.version_info >= (3, 11):
    import tomllib as toml
else:
    import tomli as toml

#: A scene: path of a file, or what such a file says as a dictionary.
Scene = Union[str, "os.PathLike[str]", Mapping[str, Any]]


def inline(value: Any, key: str = "value") -> str:
    """A value as TOML on one line. Numbers and arrays of NumPy count as numbers and lists.

    Raises TypeError, with the key, for what TOML has not.
    """
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_name(k)} = {inline(v, f'{key}.{k}')}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(inline(v, f"{key}[{n}]") for n, v in enumerate(value)) + "]"
    raise TypeError(
        f"{key}: a scene cannot say {value!r}; remedy: a number, a text, true or false, a list or a dict"
    )


def _name(key: Any) -> str:
    return str(key) if re.fullmatch(r"[A-Za-z0-9_-]+", str(key)) else inline(str(key))


def document(scene: Mapping[str, Any]) -> str:
    """A scene as TOML: its own keys, then its tables, one key a line."""

    def is_list_of_tables(value: Any) -> bool:
        return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(v, Mapping) for v in value)

    own, tables = [], []
    for key, value in scene.items():
        if isinstance(value, Mapping):
            tables += [
                f"\n[{_name(key)}]",
                *(f"{_name(k)} = {inline(v, f'{key}.{k}')}" for k, v in value.items()),
            ]
        elif is_list_of_tables(value):
            for n, table in enumerate(value):
                tables.append(f"\n[[{_name(key)}]]")
                tables += [f"{_name(k)} = {inline(v, f'{key}[{n}].{k}')}" for k, v in table.items()]
        else:
            own.append(f"{_name(key)} = {inline(value, str(key))}")
    return "\n".join(own + tables) + "\n"


def path_of(scene: Scene) -> Path | None:
    """The file of a scene that is given as one; none of a dictionary."""
    if isinstance(scene, Mapping):
        return None
    if isinstance(scene, (str, os.PathLike)):
        return Path(scene)
    raise TypeError(f"scene: {scene!r}; remedy: the path of a file, or a dict")


@contextmanager
def file_of(scene: Scene, named: bool = False) -> Iterator[Path]:
    """The file of a scene. That of a dictionary lies in the current folder, from which files in it are looked
    up, as long as it is used; `named`: its name follows from what it says."""
    if (path := path_of(scene)) is not None:
        yield path
        return
    assert isinstance(scene, Mapping)
    text = document(scene).encode()
    name = hashlib.sha256(text).hexdigest() if named else uuid.uuid4().hex
    if not os.access(".", os.W_OK):
        what = f"{Path.cwd()}: cannot write here, where the file of a scene that is a dictionary must lie"
        raise BedloadError(2, f"{what}; remedy: go to a folder where you may write, or give a file")
    path = Path(f".scene-{name[:12]}.toml")
    path.write_bytes(text)
    try:
        yield path
    finally:
        path.unlink(missing_ok=True)


def settings(values: Mapping[str, Any] | None) -> list[str]:
    """The options `--set KEY=VALUE`."""
    if not isinstance(values or {}, Mapping):
        raise TypeError(f'set: {values!r}; remedy: a dict, such as {{"grains[0].density": 2.0}}')
    return [
        word for key, value in (values or {}).items() for word in ("--set", f"{key}={inline(value, key)}")
    ]


def value_of(text: str) -> Any:
    """A value as `--set` has it."""
    return toml.loads(f"value = {text}")["value"]


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """A TOML file as a dictionary."""
    with open(path, "rb") as file:
        scene: dict[str, Any] = toml.load(file)
    return scene
