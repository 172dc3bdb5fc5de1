"""film.mp4: the grains moving over the bed, rendered by VTK, joined by ffmpeg.

Each frame is one sample of spheres.h5; grains are coloured by their speed as in picture.png. Needs an X
server as that does.
"""

import math
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from .frames import Frames, frames
from .outputs import MissingOutput, Run
from .picture import (
    GRAIN_COLOURS,
    add_colour_bar,
    camera_over,
    caption_actor,
    colour_table,
    floor_actor,
    highest_speed,
    off_screen_window,
    soft_shadows,
    sphere_actor,
)

SIZE = (1120, 560)
FRAMES_PER_SECOND = 25
HEADROOM = 2.5  # diameters above the bed's top that are shown
THICK = 1.5  # diameters of mean height above the fixed spheres: from there on grains are a bed of their own


def _chosen(run: Run, since: float, every: int, most: int) -> Iterator[tuple[float, Frames, int]]:
    """Every `every`-th instant from `since` on, at most `most`: its time, its frames, its row."""
    seen = 0
    for part in frames(run.sample_blocks(since=since)):
        for row, time in enumerate(part.time):
            if seen % every == 0:
                yield time, part, row
            seen += 1
            if seen >= most * every:
                return


def top_of_bed(run: Run, fixed_top: float, since: float) -> float:
    """Height of the bed's top [L]: of the fixed spheres, or of a thick layer of mobile ones on them.

    A layer of constant packing has its centre of mass at half of its height.
    """
    for _, part, row in _chosen(run, since, 1, 1):
        mean = float(part.position[row][:, 1].mean())
        if mean > fixed_top + THICK * run.diameter:
            return 2.0 * mean
    return fixed_top


def clock(run: Run, time: float) -> str:
    """An instant [T] in D/u_b."""
    return f"t = {time * run.bulk_velocity / run.diameter:.1f} D/u_b"


def _encoder(file: Path) -> subprocess.Popen:
    """ffmpeg that takes raw frames, the lowest line first, from its standard input."""
    width, height = SIZE
    if shutil.which("ffmpeg") is None:
        raise MissingOutput("ffmpeg is not installed, so there is no film.")
    return subprocess.Popen(
        [
            "ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", f"{width}x{height}", "-r", str(FRAMES_PER_SECOND), "-i", "-", "-vf", "vflip",
            "-c:v", "libx264", "-crf", "30", "-preset", "slow", "-pix_fmt", "yuv420p",
            "-movflags", "+faststart", str(file),
        ],
        stdin=subprocess.PIPE,
    )  # fmt: skip


def thinning(run: Run, since: float, most: int) -> int:
    """Every how many-th instant is shown, so that at most `most` frames reach from `since` to the end."""
    instants = sum(len(np.unique(time)) for time, _ in run.instants(since=since))
    return max(1, math.ceil(instants / most))


def render(run: Run, file: Path, since: float, most: int = 250) -> int:
    """Renders at most `most` frames from the time `since` to the end into `file`; returns their number.

    Raises MissingOutput, before `file` is touched, where there is no mobile sphere to be shown.
    """
    if next(_chosen(run, since, 1, 1), None) is None:
        raise MissingOutput(f"{run.folder} has no samples of mobile spheres after t = {since:g}.")
    every = thinning(run, since, most)
    bed, bed_radii = run.fixed_spheres()
    fixed_top = float((bed[:, 1] + bed_radii).max()) if len(bed) else 0.0
    bed_top = top_of_bed(run, fixed_top, since)
    shown = run.box.copy()
    shown[1] = bed_top + HEADROOM * run.diameter
    speeds = colour_table(GRAIN_COLOURS, 0.0, max(highest_speed(run, since) / run.bulk_velocity, 1e-3))

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1.0, 1.0, 1.0)
    renderer.UseFXAAOn()
    if not np.isfinite(run.periods[1]):
        renderer.AddActor(floor_actor(run.box))
    if len(bed):
        renderer.AddActor(sphere_actor(bed, bed_radii, facets=24))
    add_colour_bar(renderer, speeds, "grain speed / u_b", 0.60)
    camera_over(renderer, shown, 0.5 * bed_top, SIZE[0] / SIZE[1])
    renderer.GetActiveCamera().Zoom(1.45 if bed_top == fixed_top else 1.0)  # a thick bed is as high as it is long
    soft_shadows(renderer, 0.75 * run.diameter)
    window = off_screen_window(renderer, SIZE)

    count, grains, caption = 0, None, None
    with suppress(BrokenPipeError), _encoder(file) as encoder:  # ffmpeg that ends early has its status
        raw = encoder.stdin
        assert raw is not None  # a pipe, as _encoder asks for
        for time, part, row in _chosen(run, since, every, most):
            for actor in (grains, caption):
                if actor is not None:
                    renderer.RemoveActor(actor)
            speed = np.linalg.norm(part.velocity[row], axis=1) / run.bulk_velocity
            grains = sphere_actor(part.position[row], part.radius[row], speed, speeds, facets=24)
            caption = caption_actor(f"{run.name}, {clock(run, time)}")
            renderer.AddActor(grains)
            renderer.AddActor2D(caption)
            window.Render()
            grab = vtk.vtkWindowToImageFilter()
            grab.SetInput(window)
            grab.ReadFrontBufferOff()
            grab.Update()
            raw.write(vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).tobytes())
            count += 1
    if encoder.returncode != 0:
        raise MissingOutput(f"ffmpeg ended with status {encoder.returncode}; no {file}.")
    return count
