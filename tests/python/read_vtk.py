"""Grains and averages of a run, opened with VTK's own Python readers: what ParaView sees."""

import sys
import xml.etree.ElementTree as tree
from pathlib import Path

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPolyDataReader


def points(path):
    """The grains of one file, as arrays by name."""
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    assert data.GetNumberOfPoints() > 0, path
    assert data.GetNumberOfVerts() == data.GetNumberOfPoints(), "every grain is drawn"
    arrays = {"position": vtk_to_numpy(data.GetPoints().GetData())}
    for index in range(data.GetPointData().GetNumberOfArrays()):
        array = data.GetPointData().GetArray(index)
        arrays[array.GetName()] = vtk_to_numpy(array)
    arrays["time"] = vtk_to_numpy(data.GetFieldData().GetArray("TimeValue"))[0]
    return arrays


def check_series(folder):
    """Every file of the list opens, at its time; the last is the state in grains.csv."""
    entries = tree.parse(folder / "fields" / "grains.pvd").getroot().findall("Collection/DataSet")
    times = [float(entry.get("timestep")) for entry in entries]
    assert len(times) >= 2 and times == sorted(times), times
    for entry, time in zip(entries, times):
        grains = points(folder / "fields" / entry.get("file"))
        assert abs(grains["time"] - time) <= 1e-12 * time, (grains["time"], time)
    rows = [line for line in (folder / "grains.csv").read_text().splitlines() if not line.startswith("#")]
    names = rows[0].split(",")
    table = [dict(zip(names, row.split(","))) for row in rows[1:]]
    assert len(table) == len(grains["radius"]), "as many grains in both"
    for row, x, v, w, radius, number in zip(
        table, grains["position"], grains["velocity"], grains["spin"], grains["radius"], grains["id"]
    ):
        written = [float(row[name]) for name in ("x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz", "radius")]
        assert written == [*x, *v, *w, radius] and int(row["id"]) == number, row
    assert grains["contact_force"].shape == grains["position"].shape
    assert abs(grains["contact_force"]).max() > 0.0, "they bear forces"
    return len(times), len(table)


def check_grid(path, table):
    """The grid holds the volume of the grains."""
    reader = vtkXMLImageDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    dx, dy, dz = data.GetSpacing()
    solid = vtk_to_numpy(data.GetCellData().GetArray("solid_fraction"))
    stress = vtk_to_numpy(data.GetCellData().GetArray("stress"))
    assert stress.shape == (data.GetNumberOfCells(), 9)
    volume = solid.sum() * dx * dy * dz
    assert abs(volume / table - 1.0) < 1e-9, (volume, table)
    return data.GetNumberOfCells()


def main():
    folder = Path(sys.argv[1])
    files, grains = check_series(folder)
    rows = [line for line in (folder / "grains.csv").read_text().splitlines() if not line.startswith("#")]
    places = {name: place for place, name in enumerate(rows[0].split(","))}
    free = [row.split(",") for row in rows[1:] if row.endswith("free")]
    volume = sum(4.0 / 3.0 * 3.141592653589793 * float(row[places["radius"]]) ** 3 for row in free)
    cells = check_grid(folder / "coarse-grain.vti", volume)
    print(f"{files} files of {grains} grains and a grid of {cells} cells open with VTK")


if __name__ == "__main__":
    main()
