"""What a run leaves: its output folder as an object."""

from __future__ import annotations

import csv
import json
import math
import os
import re
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsFloat, Union, cast

import numpy as np
from numpy.typing import NDArray

from . import _vtk
from ._log import Log, Message
from ._program import BedloadError, call
from ._scene import read as read_toml

if TYPE_CHECKING:
    import pandas

__all__ = ["Grid", "Log", "Message", "Run", "Table", "Timed", "read_table"]

#: A table: of pandas where it is installed, else an array by column.
Table = Union["pandas.DataFrame", dict[str, "NDArray[Any]"]]


def columns(path: Path) -> dict[str, NDArray[Any]]:
    """A CSV file as an array by column: of floats where all are numbers, nothing being nan, else of texts. A
    last line that a run has not ended yet is left out."""
    text = path.read_text(encoding="utf-8")
    lines = text.split("\n")[:-1]
    head, *rows = list(csv.reader(line for line in lines if not line.startswith("#"))) or [[]]
    if any(len(row) != len(head) for row in rows):
        raise BedloadError(2, f"{path}: a row has not as many values as the header; remedy: run again")
    table = {}
    for n, name in enumerate(head):
        values = [row[n] for row in rows]
        try:
            table[name] = np.array([float(value or "nan") for value in values])
        except ValueError:
            table[name] = np.array(values)
    return table


def read_table(path: Path) -> Table:
    """A CSV file of Bedload, whose lines with `#` are remarks; each number to the bit."""
    table = columns(path)
    try:
        import pandas
    except ImportError:
        return table
    return cast(Table, pandas.DataFrame(table))


class Timed(np.ndarray[Any, Any]):
    """An array of the instant `time`, s."""

    time: float = float("nan")

    def __array_finalize__(self, other: object) -> None:
        self.time = getattr(other, "time", float("nan"))

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        # What is computed of it is a plain array, or a number.
        return array[()] if array.ndim == 0 else array


def _timed(values: NDArray[Any], time: float) -> Timed:
    result = values.view(Timed)
    result.time = time
    return result


@dataclass(frozen=True)
class Grid:
    """The grid of the fields, along x, y and z; `plane` has x and z, `axisymmetric` r along x, and z."""

    #: Faces of the cells, m, by axis.
    faces: dict[str, NDArray[Any]]

    @property
    def centers(self) -> dict[str, NDArray[Any]]:
        """Centres of the cells, m, by axis."""
        return {axis: (faces[1:] + faces[:-1]) / 2 for axis, faces in self.faces.items()}

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along each axis, as a field has them."""
        return tuple(len(faces) - 1 for faces in self.faces.values())


class Run:
    """The output folder of a run: finished, failed, or under way."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        if not (self.path / "scene.toml").is_file():
            raise BedloadError(
                2,
                f"{self.path}: no output folder of a run; remedy: name the folder that `out` of a run named",
            )

    def __repr__(self) -> str:
        summary = self.path / "summary.json"
        if not summary.is_file():
            return f"Run({str(self.path)!r}, not ended)"
        return f"Run({str(self.path)!r}, {self.summary['status']}, t = {self.summary['time']['simulated']} s)"

    def _need(self, name: str, remedy: str) -> Path:
        path = self.path / name
        if not path.is_file():
            raise BedloadError(2, f"{path}: the run has not left this; remedy: {remedy}")
        return path

    @property
    def scene(self) -> dict[str, Any]:
        """The scene with every default written out."""
        return read_toml(self.path / "scene.toml")

    @property
    def summary(self) -> dict[str, Any]:
        """`summary.json`: status, steps, cost, metrics with units and references (docs/results.md)."""
        text = self._need("summary.json", "wait for the end of the run").read_text(encoding="utf-8")
        return cast("dict[str, Any]", json.loads(text))

    @property
    def metrics(self) -> dict[str, float]:
        """Values of the metrics, by name; nan where there is none."""
        found = {name: metric["value"] for name, metric in self.summary["metrics"].items()}
        return {name: float("nan") if value is None else float(value) for name, value in found.items()}

    @property
    def series(self) -> Table:
        """`series.csv`: a row per observed instant. A DataFrame of pandas, or an array by column without
        pandas."""
        return self.table("series.csv")

    def table(self, name: str) -> Table:
        """A table of the folder, such as `planes` or `grains.csv`."""
        name = name if name.endswith(".csv") else f"{name}.csv"
        return read_table(self._need(name, "see docs/results.md for the key that asks for it"))

    def _grain_files(self) -> list[tuple[float, Path]]:
        return _vtk.listed(self.path / "fields" / "grains.pvd")

    def _field_files(self) -> list[tuple[float, Path]]:
        files = self.path.glob("fields/fluid_*.*vtr")
        whole = sorted(file for file in files if not re.search(r"-\d+-of-\d+$", file.stem))
        return [(_vtk.File(_vtk.pieces(file)[0]).time, file) for file in whole]

    @property
    def times(self) -> list[float]:
        """Instants of the fields and of the grains, s."""
        return sorted({time for time, _ in self._field_files() + self._grain_files()})

    def _nearest(
        self, files: list[tuple[float, Path]], time: float | None, what: str
    ) -> tuple[float, Path]:
        if not files and what == "the fluid" and "medium" not in self.scene:
            raise BedloadError(2, "the scene has no [medium]: there are no fields of a fluid")
        if not files:
            raise BedloadError(
                2, f"the run has no files of {what}; remedy: observe.fields_every or observe.fields_at"
            )
        if time is not None and not (isinstance(time, SupportsFloat) and math.isfinite(time)):
            raise BedloadError(2, f"{time!r} is no instant; remedy: one of Run.times, or none for the last")
        return files[-1] if time is None else min(files, key=lambda file: abs(file[0] - time))

    def grains(self, time: float | None = None) -> Timed:
        """The grains at the nearest instant with a file, by default the last: a structured array with
        `position`, `velocity`, `spin`, `radius`, `contact_force`, `id`, … The instant is its attribute
        `time`, s."""
        at, path = self._nearest(self._grain_files(), time, "the grains")
        file = _vtk.File(path)
        read = {name: file[name] for name in ["position", *file.section("PointData")]}
        dtype = [(name, values.dtype, values.shape[1:]) for name, values in read.items()]
        rows = np.empty(len(read["position"]), dtype)
        for name, values in read.items():
            rows[name] = values
        return _timed(rows, at)

    def field(self, name: str, time: float | None = None) -> Timed:
        """A field of the fluid, such as `velocity`, `pressure`, `vorticity`, `solid`, at the nearest instant
        with a file, by default the last, which is its attribute `time`, s.

        Its shape is that of `grid`: x first, z last; behind it the components x, y and z of a vector."""
        at, path = self._nearest(self._field_files(), time, "the fluid")
        parts = [_vtk.File(piece) for piece in _vtk.pieces(path)]
        names = parts[0].section("CellData")
        if name not in names:
            raise BedloadError(2, f"field {name!r} is not in {path}; remedy: one of {', '.join(names)}")
        values = np.concatenate([part[name] for part in parts])
        # In the file x is fastest. Axes that the grid has not are of one cell.
        shape = self._grid(parts).shape
        return _timed(
            values.reshape(*shape[::-1], *values.shape[1:]).transpose(
                *range(len(shape))[::-1], *range(len(shape), len(shape) + values.ndim - 1)
            ),
            at,
        )

    @property
    def grid(self) -> Grid:
        """The grid of the fields."""
        _, path = self._nearest(self._field_files(), None, "the fluid")
        return self._grid([_vtk.File(piece) for piece in _vtk.pieces(path)])

    @staticmethod
    def _grid(parts: list[_vtk.File]) -> Grid:
        axes = {axis: parts[0][axis] for axis in "xy"}
        axes["z"] = np.concatenate([parts[0]["z"], *(part["z"][1:] for part in parts[1:])])
        return Grid({axis: faces for axis, faces in axes.items() if len(faces) > 1})

    def mesh(self, time: float | None = None) -> Any:
        """The grains at the nearest instant as spheres of PyVista, with their data: `run.mesh().plot()`."""
        try:
            import pyvista
        except ImportError as error:
            raise ImportError(f"{error}; remedy: pip install 'bedload[pyvista]'") from error
        grains = self.grains(time)
        points = pyvista.PolyData(np.array(grains["position"]))
        for name in grains.dtype.names or ():
            points[name] = np.array(grains[name])
        return points.glyph(geom=pyvista.Sphere(radius=1.0), scale="radius", orient=False)

    @property
    def log(self) -> Log:
        """The log of the run, with those of its resumed parts: every message between the solvers."""
        self._need("exchange.mcap", "run without record=False, with grains that are free")
        number = lambda path: int((re.findall(r"\d+", path.name) or ["1"])[0])  # noqa: E731
        return Log(*sorted(self.path.glob("exchange*.mcap"), key=number))

    def report(self, show: bool = False) -> Path:
        """Makes `report.html` again, opens it in a browser if `show`, and returns its path."""
        call("report", self.path)
        page = self.path / "report.html"
        if show:
            webbrowser.open(page.absolute().as_uri())
        return page
