"""The fields of two runs, opened with VTK's own readers: every file of the first, and the one of the second at its
step, which ranks may have written in parts."""

import sys
from pathlib import Path

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPRectilinearGridReader, vtkXMLRectilinearGridReader


def grid(path):
    """All arrays of a file by name, with its extent."""
    parts = path.suffix == ".pvtr"
    reader = vtkXMLPRectilinearGridReader() if parts else vtkXMLRectilinearGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    arrays = {"extent": numpy.array(data.GetExtent())}
    for name, axis in (("x", data.GetXCoordinates()), ("y", data.GetYCoordinates()), ("z", data.GetZCoordinates())):
        arrays[name] = vtk_to_numpy(axis)
    for index in range(data.GetCellData().GetNumberOfArrays()):
        array = data.GetCellData().GetArray(index)
        arrays[array.GetName()] = vtk_to_numpy(array)
    assert data.GetNumberOfCells() > 0, path
    return arrays


def at_step(folder, stem):
    """The file of a step: the list of its parts, if there is one."""
    parts = folder / f"{stem}.pvtr"
    return parts if parts.exists() else folder / f"{stem}.vtr"


def main():
    one, other = map(Path, sys.argv[1:])
    stems = sorted(path.stem for path in one.glob("fluid_*vtr") if "-of-" not in path.stem)
    assert stems, one
    for stem in stems:
        first, second = grid(at_step(one, stem)), grid(at_step(other, stem))
        assert first.keys() == second.keys(), (stem, first.keys(), second.keys())
        for name, values in first.items():
            assert values.tobytes() == second[name].tobytes(), f"{name} differs in {at_step(other, stem)}"
    print(f"{other}: {len(stems)} files of {len(first) - 4} fields as in {one}")


if __name__ == "__main__":
    main()
