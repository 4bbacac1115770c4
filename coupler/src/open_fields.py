"""A run in ParaView: the fluid's speed, in space on a slice, and the grains as spheres, with their time.

    paraview --script=open_fields.py          the window, with its time bar
    pvbatch open_fields.py PICTURE.png        the last instant as a picture
"""

import os
import sys

from paraview.simple import *

fields = os.path.join("FOLDER", "fields")
view = GetActiveViewOrCreate("RenderView")
picture = sys.argv[1] if len(sys.argv) > 1 else None
if picture:
    view.ViewSize = [1280, 720]


def opened(name):
    path = os.path.join(fields, name)
    if not os.path.isfile(path):
        return None
    reader = PVDReader(registrationName=name, FileName=path)
    reader.UpdatePipeline()
    return reader


def bounds(source):
    box = source.GetDataInformation().GetBounds()
    return [(box[2 * a], box[2 * a + 1]) for a in range(3)]


fluid, grains = opened("fluid.pvd"), opened("grains.pvd")
if fluid:
    shown, box = fluid, bounds(fluid)
    if all(high > low for low, high in box):
        shown = Slice(registrationName="slice", Input=fluid)
        shown.SliceType.Origin = [(low + high) / 2 for low, high in box]
        shown.SliceType.Normal = [0.0, 1.0, 0.0]
    display = Show(shown, view)
    ColorBy(display, ("CELLS", "velocity", "Magnitude"))
    display.SetScalarBarVisibility(view, True)
if grains:
    spheres = Glyph(registrationName="spheres", Input=grains, GlyphType="Sphere")
    spheres.ScaleArray = ["POINTS", "radius"]
    spheres.ScaleFactor = 2.0  # the sphere of ParaView has a diameter of 1
    spheres.GlyphMode = "All Points"
    spheres.GlyphType.ThetaResolution = spheres.GlyphType.PhiResolution = 24
    display = Show(spheres, view)
    if fluid:
        display.ColorArrayName = [None, ""]
    else:
        ColorBy(display, ("POINTS", "velocity", "Magnitude"))
        display.SetScalarBarVisibility(view, True)
Show(AnnotateTimeFilter(Input=fluid or grains, Format="t = {time:g} s"), view)

animation = GetAnimationScene()
animation.UpdateAnimationUsingDataTimeSteps()
coloured = shown.CellData if fluid else spheres.PointData
times = list((fluid or grains).TimestepValues)
# The fastest of all instants, or of some 20 of many.
fastest = 0.0
for time in times[:: -(-len(times) // 20)] + times[-1:]:
    (shown if fluid else spheres).UpdatePipeline(time)
    fastest = max(fastest, coloured["velocity"].GetRange(-1)[1])
animation.GoToLast()
GetColorTransferFunction("velocity").RescaleTransferFunction(0.0, fastest)
bar = GetScalarBar(GetColorTransferFunction("velocity"), view)
bar.Orientation, bar.WindowLocation = "Horizontal", "Lower Center"
# z upwards, x to the right.
view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]
view.ResetCamera(False)
Render(view)
if picture:
    SaveScreenshot(picture, view, ImageResolution=view.ViewSize)
