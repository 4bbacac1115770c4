"""What a run left, read with NumPy alone, beside other readers."""

import csv
import subprocess
import sys

import numpy as np
import pytest

import bedload
from bedload import _results


def test_series_is_the_table(finished):
    with open(finished.path / "series.csv", newline="") as file:
        head, *rows = csv.reader(file)
    for table in (finished.series, _results.columns(finished.path / "series.csv")):
        assert list(table) == head and len(rows) == 100
        for name, values in zip(head, zip(*rows)):
            assert np.array_equal(np.asarray(table[name]), [float(value) for value in values]), name
    assert list(_results.columns(finished.path / "grains.csv")["motion"]) == ["free"]
    with pytest.raises(bedload.BedloadError, match="planes.csv"):
        finished.table("planes.csv")


def test_a_series_under_way_is_read_as_far_as_it_goes(finished, tmp_path):
    lines = (finished.path / "series.csv").read_text().splitlines(keepends=True)
    (tmp_path / "series.csv").write_text("".join(lines[:4]) + lines[4][:-3])
    table = _results.columns(tmp_path / "series.csv")
    assert [len(values) for values in table.values()] == [3] * len(table)
    (tmp_path / "series.csv").write_text("".join(lines[:4]) + "1,2\n")
    with pytest.raises(bedload.BedloadError, match="as many values"):
        _results.columns(tmp_path / "series.csv")
    (tmp_path / "series.csv").write_text("")
    assert _results.columns(tmp_path / "series.csv") == {}


def test_a_log_that_breaks_off_is_an_error_with_a_remedy(finished, tmp_path):
    log = (finished.path / "exchange.mcap").read_bytes()
    # The first frame of Zstandard says of itself that it is none.
    other = log.replace(b"\x28\xb5\x2f\xfd", b"\x28\xb5\x2f\x00", 1)
    for left in (*(log[:size] for size in (0, 20, len(log) // 2, len(log) - 9)), other):
        (tmp_path / "exchange.mcap").write_bytes(left)
        with pytest.raises(bedload.BedloadError, match="bedload log repair") as error:
            list(_results.Log(tmp_path / "exchange.mcap").messages())
        assert error.value.kind == "damaged-log"


def test_series_without_pandas(finished):
    script = (
        "import sys; sys.modules['pandas'] = None; import bedload; "
        f"series = bedload.Run({str(finished.path)!r}).series; print(type(series).__name__, series['t'][-1])"
    )
    words = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert words.stdout.split() == ["dict", "2.0"]


def test_the_programs_start_without_numpy():
    script = "import sys, bedload; print('numpy' in sys.modules)"
    words = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert words.stdout.strip() == "False"


def test_grains_at_the_nearest_time(finished):
    assert np.allclose(finished.times, [0.5, 1.0, 1.5, 2.0])
    grains = finished.grains(0.7)
    assert grains.time == finished.times[0] and grains.shape == (1,)
    series = finished.series
    row = list(np.isclose(series["t"], 0.5)).index(True)
    assert grains["position"][0, 2] == np.asarray(series["position_z[0]"])[row]
    assert grains["velocity"][0, 2] == np.asarray(series["velocity_z[0]"])[row]
    assert grains["radius"][0] == 0.5 and grains["id"][0] == 0
    assert finished.grains().time == finished.times[-1]
    for time in (float("nan"), float("inf")):
        with pytest.raises(bedload.BedloadError, match="Run.times"):
            finished.grains(time)


def test_a_field_on_its_grid(finished):
    grid, velocity = finished.grid, finished.field("velocity", 1.01)
    assert grid.shape == (50, 80) and list(grid.faces) == ["x", "z"]
    assert velocity.shape == (50, 80, 3) and velocity.time == finished.times[1]
    assert np.allclose(grid.centers["z"], (np.arange(80) + 0.5) * 0.1)
    solid, grains = finished.field("solid", 1.0), finished.grains(1.0)
    # In the grain the fluid moves as it does; it lies where the solid is.
    centre = np.abs(grid.centers["z"] - grains["position"][0, 2]).argmin()
    assert solid[0, centre] > 0.9
    assert velocity[0, centre, 2] == pytest.approx(grains["velocity"][0, 2], rel=0.05)
    # Its centre of mass is the grain's: the mask is smeared over a cell, alike above and below.
    rings = np.diff(grid.faces["x"] ** 2)[:, None] * np.diff(grid.faces["z"])
    height = (solid * rings * grid.centers["z"]).sum() / (solid * rings).sum()
    assert height == pytest.approx(grains["position"][0, 2], abs=0.01)
    assert type(height) is np.float64 and type(2 * solid) is np.ndarray and solid[3:].time == solid.time
    with pytest.raises(bedload.BedloadError, match="one of velocity, pressure"):
        finished.field("temperature")


def test_files_are_read_as_vtk_reads_them(finished):
    pyvista = pytest.importorskip("pyvista")
    path = next(path for time, path in finished._field_files() if time == finished.times[0])
    whole = pyvista.read(path)
    for name in ("velocity", "pressure", "vorticity", "solid"):
        # VTK counts cells with x fastest.
        own = np.moveaxis(finished.field(name, 0.5), 0, 1)
        assert np.array_equal(np.asarray(whole.cell_data[name]).ravel(), np.asarray(own).ravel()), name
    mesh = finished.mesh(0.5)
    assert mesh.center[2] == pytest.approx(finished.grains(0.5)["position"][0, 2], abs=1e-6)
    assert mesh.bounds[5] - mesh.bounds[4] == pytest.approx(1.0, rel=1e-6)
    grains = pyvista.read(finished._grain_files()[0][1])
    assert np.array_equal(grains.points, finished.grains(0.5)["position"])


def test_fields_in_space_and_in_several_files(tmp_path):
    """Two files of ranks, laid one on the other along z: 2 x 3 x (1 + 2) cells."""

    def part(name, first, layers):
        values = np.arange(6 * layers, dtype="<f8") + 6 * first
        blocks = [values, np.arange(3.0), np.arange(4.0), np.arange(layers + 1.0) + first]
        tags, offset, data = [], 0, b""
        for label, block in zip(("pressure", "x", "y", "z"), blocks):
            tags.append(
                f'<DataArray type="Float64" Name="{label}" NumberOfComponents="1" format="appended" '
                f'offset="{offset}"/>'
            )
            data += np.uint64(block.nbytes).tobytes() + block.tobytes()
            offset = len(data)
        header = (
            '<VTKFile type="RectilinearGrid"><DataArray type="Float64" Name="TimeValue" format="ascii">5e-1'
            f"</DataArray><CellData>\n{tags[0]}\n</CellData><Coordinates>{''.join(tags[1:])}</Coordinates>"
            '<AppendedData encoding="raw">\n_'
        )
        (tmp_path / "fields" / name).write_bytes(header.encode() + data + b"</AppendedData></VTKFile>")

    (tmp_path / "fields").mkdir()
    (tmp_path / "scene.toml").write_text("")
    part("fluid_00000001-0-of-2.vtr", 0, 1)
    part("fluid_00000001-1-of-2.vtr", 1, 2)
    (tmp_path / "fields" / "fluid_00000001.pvtr").write_text(
        "".join(f'<Piece Extent="" Source="fluid_00000001-{rank}-of-2.vtr"/>\n' for rank in range(2))
    )
    run = bedload.Run(tmp_path)
    assert run.times == [0.5] and run.grid.shape == (2, 3, 3)
    pressure = run.field("pressure")
    assert pressure.shape == (2, 3, 3)
    assert pressure[1, 0, 0] == 1.0 and pressure[0, 1, 0] == 2.0 and pressure[0, 0, 2] == 12.0


def test_the_log_has_every_message(finished):
    pytest.importorskip("mcap")
    log = finished.log
    assert log.topics["loads"] == log.topics["kinematics"] == 100
    assert log.manifest["grains"] == "1" and "axisymmetric" in log.scene
    rows = {message.step: message for message in log.messages("kinematics")}
    series = finished.series
    heights = [rows[step].grains["position"][0, 2] for step in sorted(rows)]
    assert np.array_equal(heights, np.asarray(series["position_z[0]"]))
    loads = next(log.messages("loads"))
    assert loads.head["header.dt"] == 0.02 and loads.grains["added_mass"][0] > 0.0
    frame = next(log.messages("viewer/window"))
    assert frame.head.time == frame.time == 0.02
    assert next(log.messages("status")).head["text"] == ""
    with pytest.raises(bedload.BedloadError, match="no topic 'nope'.*loads"):
        next(log.messages("nope"))


def test_the_report_is_made_again(finished):
    page = finished.path / "report.html"
    page.unlink()
    assert finished.report() == page and page.stat().st_size > 10_000


def test_a_folder_of_others_is_refused(tmp_path):
    with pytest.raises(bedload.BedloadError, match="no output folder"):
        bedload.Run(tmp_path)


def test_a_table_by_its_name_and_an_instant_that_is_none(finished):
    rows = list(finished.table("grains")["id"])
    assert rows == list(finished.table("grains.csv")["id"])
    with pytest.raises(bedload.BedloadError, match="'x' is no instant"):
        finished.grains("x")


def test_a_scene_without_a_fluid_has_no_fields(scene):
    scene.pop("medium"), scene.pop("fluid"), scene.pop("metrics")
    run = bedload.run(scene, "dry", until=0.1)
    with pytest.raises(bedload.BedloadError, match="no \\[medium\\]"):
        run.field("velocity")
