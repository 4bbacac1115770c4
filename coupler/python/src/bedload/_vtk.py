"""The VTK files of a run, read with NumPy alone: header in XML, arrays appended as raw binary
(protocol/output)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Longest header, bytes. Ours have some 2 kB.
HEADER = 1 << 16
KINDS = {"Float64": "<f8", "Int64": "<i8"}


def attribute(tag: str, name: str) -> str | None:
    """Text of an attribute of a tag."""
    found = re.search(rf'(?:^| ){name}="([^"]*)"', tag)
    return found[1] if found else None


class File:
    """A `.vtp` or `.vtr` file: its time, and its arrays by name, read when they are asked for."""

    def __init__(self, path: Path) -> None:
        with open(path, "rb") as file:
            start = file.read(HEADER)
        at = start.find(b'<AppendedData encoding="raw">')
        if at < 0:
            raise ValueError(f"{path}: no VTK file with appended raw data")
        self.path, self.data = path, start.index(b"_", at) + 1
        self.header = start[:at].decode()
        time = re.search(r'Name="TimeValue"[^>]*>([^<]*)<', self.header)
        self.time = float(time[1]) if time else float("nan")
        tags = [tag for tag in re.findall(r"<DataArray ([^>]*)>", self.header) if 'format="appended"' in tag]
        self.tags = {attribute(tag, "Name"): tag for tag in tags}

    def section(self, name: str) -> list[str]:
        """Names of the arrays of a section, such as CellData."""
        inside = re.search(rf"<{name}>(.*?)</{name}>", self.header, re.S)
        return re.findall(r' Name="([^"]*)"', inside[1]) if inside else []

    def __getitem__(self, name: str) -> NDArray[Any]:
        """An array: a row for each point or cell if it has several components."""
        tag = self.tags[name]
        offset, width = int(attribute(tag, "offset") or 0), int(attribute(tag, "NumberOfComponents") or 1)
        with open(self.path, "rb") as file:
            file.seek(self.data + offset)
            count = int.from_bytes(file.read(8), "little") // 8
            values = np.fromfile(file, KINDS[attribute(tag, "type") or ""], count)
        if len(values) != count:
            raise ValueError(f"{self.path}: array {name} lies beyond the end of the file")
        return values if width == 1 else values.reshape(-1, width)


def pieces(path: Path) -> list[Path]:
    """The files of a grid: itself, or those that a `.pvtr` names, in order along z."""
    if path.suffix != ".pvtr":
        return [path]
    return [path.with_name(name) for name in re.findall(r'<Piece [^>]*Source="([^"]*)"', path.read_text())]


def listed(path: Path) -> list[tuple[float, Path]]:
    """Times and files of a list (`.pvd`)."""
    tags = re.findall(r"<DataSet ([^>]*)/>", path.read_text()) if path.is_file() else []
    return [
        (float(attribute(tag, "timestep") or "nan"), path.with_name(attribute(tag, "file") or ""))
        for tag in tags
    ]
