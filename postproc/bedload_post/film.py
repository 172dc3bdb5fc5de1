"""film.mp4: the grains moving over the bed, rendered by VTK, joined by ffmpeg.

Each frame is one sample of spheres.h5; grains are coloured by their speed as in picture.png. Needs an X
server as that does.
"""

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from .frames import Frames, frames
from .outputs import MissingOutput, Run
from .picture import (
    GRAIN_COLOURS,
    camera_over,
    caption_actor,
    colour_bar,
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


def render(run: Run, file: Path, since: float, every: int = 2, most: int = 250) -> int:
    """Renders `most` frames from the time `since` on into `file`; returns how many there were."""
    bed, bed_radii = run.fixed_spheres()
    bed_top = float((bed[:, 1] + bed_radii).max()) if len(bed) else 0.0
    shown = run.box.copy()
    shown[1] = bed_top + HEADROOM * run.diameter
    speeds = colour_table(GRAIN_COLOURS, 0.0, max(highest_speed(run) / run.bulk_velocity, 1e-3))

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1.0, 1.0, 1.0)
    renderer.UseFXAAOn()
    renderer.AddActor(floor_actor(run.box))
    if len(bed):
        renderer.AddActor(sphere_actor(bed, bed_radii, facets=24))
    renderer.AddActor2D(colour_bar(speeds, "grain speed / u_b", 0.60))
    camera_over(renderer, shown, 0.5 * bed_top)
    renderer.GetActiveCamera().Zoom(1.45)
    soft_shadows(renderer, 0.75 * run.diameter)
    window = off_screen_window(renderer, SIZE)

    count, grains, caption = 0, None, None
    with _encoder(file) as encoder:
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
            encoder.stdin.write(vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).tobytes())
            count += 1
    if count == 0:
        raise MissingOutput(f"{run.folder} has no samples of mobile spheres after t = {since:g}.")
    if encoder.returncode != 0:
        raise MissingOutput(f"ffmpeg ended with status {encoder.returncode}; no {file}.")
    return count
