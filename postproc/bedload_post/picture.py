"""picture.png: the scene at the last snapshot, rendered by VTK.

Streamwise velocity on an upright plane along the flow, through the fastest grain, and on one across
it at the box's end; the bed in grey, mobile spheres coloured by their speed. VTK of Debian 12
renders without a screen only under a virtual X server (`xvfb-run -a`).
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import vtk
from matplotlib import colormaps
from vtk.util.numpy_support import numpy_to_vtk

from .outputs import Run, Samples, Snapshot

SIZE = (1800, 1000)
# Colour map and the part of it in use; a grain at rest stays apart from fast fluid.
FLOW_COLOURS, GRAIN_COLOURS = ("YlGnBu_r", 0.0, 1.0), ("YlOrRd", 0.4, 0.85)
INK = (0.13, 0.15, 0.18)


def colour_table(colours: tuple[str, float, float], low: float, high: float) -> vtk.vtkLookupTable:
    """A part of a matplotlib colour map as a VTK table over [low, high]."""
    name, first, last = colours
    table = vtk.vtkLookupTable()
    table.SetNumberOfTableValues(256)
    for i, colour in enumerate(colormaps[name](np.linspace(first, last, 256))):
        table.SetTableValue(i, *colour)
    table.SetRange(low, high)
    table.Build()
    return table


def _centres(faces: np.ndarray) -> np.ndarray:
    return 0.5 * (faces[1:] + faces[:-1])


def _plane(
    snapshot: Snapshot, normal: int, at: float, table: vtk.vtkLookupTable
) -> vtk.vtkActor:
    """u on the plane normal to axis `normal` (0, 1, 2 for x, y, z) at the coordinate `at`."""
    faces = [snapshot.x, snapshot.y, snapshot.z]
    axis = 2 - normal  # of the arrays, stored (z, y, x)
    index = int(np.argmin(np.abs(_centres(faces[normal]) - at)))
    values = np.take(snapshot.u, index, axis=axis)

    grid = vtk.vtkRectilinearGrid()
    coordinates = [
        np.array([at]) if d == normal else np.asarray(_centres(faces[d])) for d in range(3)
    ]
    # The outermost samples are drawn out to the box's ends, half a cell away.
    for d in range(3):
        if d != normal:
            coordinates[d] = coordinates[d].copy()
            coordinates[d][[0, -1]] = faces[d][[0, -1]]
    grid.SetDimensions(*map(len, coordinates))
    grid.SetXCoordinates(numpy_to_vtk(coordinates[0], deep=True))
    grid.SetYCoordinates(numpy_to_vtk(coordinates[1], deep=True))
    grid.SetZCoordinates(numpy_to_vtk(coordinates[2], deep=True))
    field = numpy_to_vtk(np.ascontiguousarray(values, dtype=np.float32).ravel(), deep=True)
    field.SetName("u")
    grid.GetPointData().SetScalars(field)

    surface = vtk.vtkGeometryFilter()
    surface.SetInputData(grid)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(surface.GetOutputPort())
    mapper.SetLookupTable(table)
    mapper.SetScalarRange(*table.GetRange())
    mapper.InterpolateScalarsBeforeMappingOn()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    return actor


def sphere_actor(
    centres: np.ndarray, radii: np.ndarray, speed=None, table=None, facets: int = 48
) -> vtk.vtkActor:
    """Spheres at `centres` (n, 3); grey, or coloured by `speed` (n)."""
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(centres, dtype=np.float32), deep=True))
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    for name, values in (("radius", radii), ("speed", speed)):
        if values is not None:
            array = numpy_to_vtk(np.asarray(values, dtype=np.float32), deep=True)
            array.SetName(name)
            data.GetPointData().AddArray(array)
    ball = vtk.vtkSphereSource()
    ball.SetRadius(1.0)
    ball.SetThetaResolution(facets)
    ball.SetPhiResolution(2 * facets // 3)
    mapper = vtk.vtkGlyph3DMapper()
    mapper.SetInputData(data)
    mapper.SetSourceConnection(ball.GetOutputPort())
    mapper.SetScaleArray("radius")
    mapper.SetScaleModeToScaleByMagnitude()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetInterpolationToPhong()
    look.SetAmbient(0.25)
    look.SetDiffuse(0.75)
    look.SetSpecular(0.25)
    look.SetSpecularPower(30)
    if speed is None:
        mapper.ScalarVisibilityOff()
        look.SetColor(0.82, 0.80, 0.75)
    else:
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("speed")
        mapper.SetLookupTable(table)
        mapper.SetScalarRange(*table.GetRange())
    return actor


def frame_actor(box: np.ndarray) -> vtk.vtkActor:
    cube = vtk.vtkCubeSource()
    cube.SetBounds(0, box[0], 0, box[1], 0, box[2])
    edges = vtk.vtkExtractEdges()
    edges.SetInputConnection(cube.GetOutputPort())
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(edges.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*INK)
    actor.GetProperty().SetLineWidth(1.5)
    actor.GetProperty().SetLighting(False)
    return actor


def floor_actor(box: np.ndarray) -> vtk.vtkActor:
    plane = vtk.vtkPlaneSource()
    plane.SetOrigin(0, 0, 0)
    plane.SetPoint1(box[0], 0, 0)
    plane.SetPoint2(0, 0, box[2])
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(plane.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.45, 0.43, 0.40)
    return actor


def shown_range(u: np.ndarray) -> tuple[float, float]:
    """Of the colours for a velocity: from rest to the fastest, or from the slowest where much of it goes backwards;
    eddies behind grains do not count."""
    lowest, highest = (float(value) for value in np.percentile(u, (0.2, 99.8)))
    return (lowest, highest) if lowest < -0.25 * abs(highest) else (0.0, highest)


def _style_text(style: vtk.vtkTextProperty, size: int) -> None:
    style.SetFontFamilyToArial()
    style.SetFontSize(size)
    style.SetColor(*INK)
    style.BoldOff()
    style.ItalicOff()
    style.ShadowOff()


def text_actor(text: str, left: float, lower: float, size: int) -> vtk.vtkTextActor:
    """Text that begins at a place given in shares of the picture's width and height."""
    actor = vtk.vtkTextActor()
    actor.SetInput(text)
    _style_text(actor.GetTextProperty(), size)
    actor.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    actor.SetPosition(left, lower)
    return actor


def add_colour_bar(renderer: vtk.vtkRenderer, table: vtk.vtkLookupTable, title: str, left: float) -> None:
    """A bar with its numbers, and its title above them: a title of the bar's own would touch the numbers."""
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetOrientationToHorizontal()
    bar.SetNumberOfLabels(5)
    bar.SetLabelFormat("%.2g")
    bar.UnconstrainedFontSizeOn()
    bar.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    bar.SetPosition(left, 0.015)
    bar.SetWidth(0.32)
    bar.SetHeight(0.07)
    bar.SetBarRatio(0.43)
    _style_text(bar.GetLabelTextProperty(), 20)
    renderer.AddActor2D(bar)
    renderer.AddActor2D(text_actor(title, left, 0.085, 24))


def caption_actor(text: str) -> vtk.vtkTextActor:
    return text_actor(text, 0.03, 0.945, 28)


def bring_into_view(
    snapshot: Snapshot, periods: np.ndarray, grain: np.ndarray
) -> tuple[Snapshot, np.ndarray]:
    """Turns a periodic box so that `grain` (3) comes to 0.4 of its length and to its back (z = 0).

    Returns the turned fields and the shift (3) of positions, a whole number of cells.
    """
    shift = np.zeros(3)
    u = snapshot.u
    for d, (faces, place) in enumerate(zip((snapshot.x, snapshot.y, snapshot.z), (0.4, 0, 0))):
        if d != 1 and np.isfinite(periods[d]):
            h = faces[1] - faces[0]
            cells = math.ceil((place * periods[d] - grain[d]) / h - 1e-9)
            u = np.roll(u, cells, axis=2 - d)
            shift[d] = cells * h
    return replace(snapshot, u=u), shift


def how_turned(periods: np.ndarray) -> str:
    """What `bring_into_view` did to a box, for its caption."""
    if np.isfinite(periods[2]):
        return " (periodic box turned: the plane along the flow cuts the fastest grain)"
    return " (periodic box turned)" if np.isfinite(periods[0]) else ""


def _latest(run: Run, time: float) -> Samples | None:
    """Each mobile sphere's last sample up to `time`; None where there is none."""
    latest: Samples | None = None
    for block in run.sample_blocks():
        rows = np.flatnonzero(block.time <= time * (1 + 1e-9) + 1e-12)
        if len(rows) == 0:
            break
        last_time = block.time[rows[-1]]
        rows = rows[block.time[rows] == last_time]
        latest = block.rows(rows)
    return latest


def wrap(position: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Positions (n, 3) inside the box where it is periodic; a rounding below 0 stays at 0."""
    period = np.where(np.isfinite(periods), periods, 1.0)
    turns = np.where(np.isfinite(periods), np.floor(position / period + 1e-9), 0.0)
    return position - turns * period


def highest_speed(run: Run, since: float = -np.inf) -> float:
    """Of any mobile sphere from `since` on, in the whole run: one colour means one speed in all its pictures."""
    speeds = (np.linalg.norm(b.velocity, axis=1).max() for b in run.sample_blocks(since=since) if len(b))
    return float(max(speeds, default=0.0))


def soft_shadows(renderer: vtk.vtkRenderer, reach: float) -> None:
    """Darkens what lies close under something else, as far as `reach` [L]."""
    renderer.UseSSAOOn()
    renderer.SetSSAORadius(reach)
    renderer.SetSSAOBias(0.02 * reach)
    renderer.SetSSAOKernelSize(128)
    renderer.SSAOBlurOn()


# Of the picture's height from its middle, in halves: what lies above is the caption's, below the colour bars'.
HIGHEST, LOWEST, RISE = 0.87, -0.76, 0.13


def camera_over(renderer: vtk.vtkRenderer, box: np.ndarray, focus_y: float, aspect: float) -> None:
    """Looks down the flow from the side and above, the whole box in view, clear of caption and colour bars, in a
    picture `aspect` times as wide as high."""
    camera = vtk.vtkCamera()
    focus = np.array([0.5 * box[0], focus_y, 0.5 * box[2]])
    towards = np.array([-0.42, 0.50, 1.0])
    camera.SetFocalPoint(*focus)
    camera.SetPosition(*(focus + 3.0 * box.max() * towards))
    camera.SetViewUp(0, 1, 0)
    camera.SetViewAngle(22)
    renderer.SetActiveCamera(camera)
    renderer.ResetCamera(0, box[0], 0, box[1], 0, box[2])
    view = camera.GetCompositeProjectionTransformMatrix(aspect, -1, 1)
    corners = [view.MultiplyPoint((*(box * corner), 1.0)) for corner in np.ndindex(2, 2, 2)]
    across = max(abs(x / w) for x, _, _, w in corners)
    above, below = max(y / w for _, y, _, w in corners), max(-y / w for _, y, _, w in corners)
    camera.Zoom(min(0.97 / across, (HIGHEST - RISE) / above, (RISE - LOWEST) / below))
    camera.SetWindowCenter(0.0, -RISE)  # leaves the lower edge to the colour bars
    renderer.ResetCameraClippingRange()


def off_screen_window(renderer: vtk.vtkRenderer, size: tuple[int, int]) -> vtk.vtkRenderWindow:
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)  # FXAA smooths instead
    window.SetSize(*size)
    window.AddRenderer(renderer)
    return window


def render(run: Run, file: Path) -> None:
    """Renders the latest snapshot of `run` into `file`. Raises MissingOutput without fields."""
    snapshot = run.last_snapshot()
    box, scale = run.box, run.bulk_velocity
    bed, bed_radii = run.fixed_spheres()
    mobile = _latest(run, snapshot.time)

    lowest, highest = shown_range(snapshot.u)
    snapshot = replace(snapshot, u=snapshot.u / scale)
    if mobile is not None:
        fastest = mobile.position[np.argmax(np.linalg.norm(mobile.velocity, axis=1))]
        snapshot, shift = bring_into_view(snapshot, run.periods, fastest)
        bed, grains = wrap(bed + shift, run.periods), wrap(mobile.position + shift, run.periods)

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1.0, 1.0, 1.0)
    renderer.UseFXAAOn()
    flow = colour_table(FLOW_COLOURS, lowest / scale, max(highest / scale, lowest / scale + 1e-12))
    bed_top = float((bed[:, 1] + bed_radii).max()) if len(bed) else 0.0
    if not np.isfinite(run.periods[1]):
        renderer.AddActor(floor_actor(box))
    renderer.AddActor(_plane(snapshot, 2, 0.0, flow))
    renderer.AddActor(_plane(snapshot, 0, box[0], flow))
    if len(bed):
        renderer.AddActor(sphere_actor(bed, bed_radii))
    caption = f"{run.name}, t = {snapshot.time:.4g}"
    if mobile is not None:
        caption += how_turned(run.periods)
        speed = np.linalg.norm(mobile.velocity, axis=1) / scale
        speeds = colour_table(GRAIN_COLOURS, 0.0, max(highest_speed(run) / scale, 1e-3))
        renderer.AddActor(sphere_actor(grains, mobile.radius, speed, speeds))
        add_colour_bar(renderer, speeds, "grain speed / u_b", 0.60)
    add_colour_bar(renderer, flow, "streamwise velocity u / u_b", 0.08)
    renderer.AddActor(frame_actor(box))
    renderer.AddActor2D(caption_actor(caption))
    camera_over(renderer, box, 0.5 * (bed_top + box[1]), SIZE[0] / SIZE[1])

    if len(bed):
        soft_shadows(renderer, 1.5 * float(bed_radii.max()))

    window = off_screen_window(renderer, SIZE)
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    image.Update()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(file))
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()
