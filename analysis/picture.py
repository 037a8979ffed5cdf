"""What does the packing look like? A picture for a paper, by exact rays, without a display."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable
from typing import TYPE_CHECKING

import MDAnalysis as mda
import numpy as np
from matplotlib.image import imsave
from numpy.typing import NDArray
from PIL import Image

from analysis import colours
from analysis.raycasting import draw_bodies, draw_segment, empty_map, surfaces
from analysis.shading import GLOSS, develop, frame_towards, light_on, visible_samples
from ccd.annotations import AnyPath, ArrayLike, Floats
from ccd.contacts import contact_numbers, contact_pairs, rattlers

if TYPE_CHECKING:
    from MDAnalysis import Universe

RAYS = 3  # rays a side of a pixel
MARGIN = 1.03
EDGE_SHADE = 0.02
VIEW = (0.42, -1.0, 0.36)
Bodies = tuple[Floats, Floats, Floats]  # positions (n, 3), orientations (n, 4), semi-axes (n, 3)


def render(source: AnyPath | Universe, output: AnyPath, frame: int = -1, colour: str = "orientation", size: tuple[int, int] = (900, 900),
           view: ArrayLike = VIEW, cell: bool = True, contact_gap: float = 1e-5) -> str:
    """Draw one frame of a run into a PNG file.

    `source` is the path of an edmd file, or a Universe of one, whose current frame stays as it is; `frame` its number,
    negative from the end. `colour`: "orientation", "species" or "contacts" (of a gap mu - 1
    below `contact_gap`; see analysis.colours). `size` is (width,
    height) in pixels; `view` the direction from which one looks, in the lab, with z up; `cell` draws the edges of the
    periodic cell. Every body is drawn whole, its center inside the cell. Returns the path written. ValueError for any other
    colour, a frame that is not there, a size below one pixel or a view of length zero.
    """
    ((bodies, paint, box),) = scenes(source, [frame], colour, cell, contact_gap)
    imsave(output, image(bodies, paint, box, size, view))
    return os.fspath(output)


def render_series(source: AnyPath | Universe, output: AnyPath, frames: Iterable[int] | None = None, colour: str = "orientation",
                  size: tuple[int, int] = (900, 900), view: ArrayLike = VIEW, cell: bool = True, contact_gap: float = 1e-5,
                  per_second: float = 25) -> list[str]:
    """Draw frames of a run as a movie, all from one camera that has every one of them in its picture.

    `output`: a name that ends in .gif, a movie of `per_second` pictures a second that repeats itself, in 256 colours; or a folder, made
    when it is not there, for pictures 00000.png, 00001.png, ..., of which other programs make movies: `ffmpeg -framerate 25 -i
    movie/%05d.png -pix_fmt yuv420p movie.mp4`. `frames`: their numbers, by default all; the rest as `render`. Returns the paths
    written. ValueError as there.
    """
    if not 0 < per_second < np.inf:
        raise ValueError(f"per_second: {per_second}; a positive number is needed")
    window = None
    for bodies, _, box in scenes(source, frames, colour, cell, contact_gap):
        window = joined(window, window_of(bodies, box, view))
    pictures = (image(bodies, paint, box, size, view, window) for bodies, paint, box in scenes(source, frames, colour, cell, contact_gap))
    if os.fspath(output).lower().endswith(".gif"):
        first, *others = map(in_256_colours, pictures)
        first.save(output, save_all=True, append_images=others, duration=1000 / per_second, loop=0)
        return [os.fspath(output)]
    os.makedirs(output, exist_ok=True)
    paths = []
    for number, pixels in enumerate(pictures):
        paths.append(os.path.join(output, f"{number:05d}.png"))
        imsave(paths[-1], pixels)
    return paths


def in_256_colours(pixels):
    """A picture with a palette of its own."""
    picture = Image.fromarray(pixels)
    return picture.quantize(palette=picture.quantize(), dither=Image.Dither.FLOYDSTEINBERG)


def scenes(source, frames, colour, cell, contact_gap):
    """Bodies, paint and cell (None: not to be drawn), as `image` takes them, of frames one after the other."""
    if colour not in ("orientation", "species", "contacts"):
        raise ValueError(f'colour: {colour!r}; "orientation", "species" or "contacts" is needed')
    opened = not isinstance(source, mda.Universe)
    universe = mda.Universe(source) if opened else source
    trajectory = universe.trajectory
    current = trajectory.frame
    try:
        for frame in range(len(trajectory)) if frames is None else frames:
            if not -len(trajectory) <= frame < len(trajectory):
                raise ValueError(f"frame: {frame}; the run has {len(trajectory)}; negative counts from the end")
            data = trajectory[frame].data
            bodies = tuple(data[name].copy() for name in ("position", "orientation", "semi_axes"))
            yield bodies, body_colours(colour, universe.atoms, data, contact_gap), data["cell"].copy() if cell else None
    finally:
        if opened:
            trajectory.close()
        else:
            trajectory[current]


def body_colours(colour, atoms, data, contact_gap):
    """Linear RGB (n, 3) of the bodies of a frame."""
    if colour == "species":
        return colours.species_colours(atoms.types.astype(int))
    if colour == "contacts":
        pairs = contact_pairs(data["position"], data["orientation"], data["semi_axes"], data["cell"], contact_gap)
        return colours.contact_colours(contact_numbers(pairs, len(atoms)), rattlers(pairs, len(atoms)))
    return colours.orientation_colours(data["orientation"], data["semi_axes"])


def image(bodies: Bodies, paint: Floats, cell: ArrayLike | None = None, size: tuple[int, int] = (900, 900),
          view: ArrayLike = VIEW, window: tuple[Floats, Floats] | None = None) -> NDArray[np.uint8]:
    """The picture of ellipsoids as sRGB bytes (height, width, 3), on white, in parallel projection.

    `bodies` are (positions (n, 3), orientations (n, 4) scalar first, semi_axes (n, 3)); `paint` (n, 3) linear RGB; `cell`
    (3, 3), rows are the cell vectors, or None to draw no edges; `size` (width, height); `view` (3,) the direction from
    which one looks, with z up. The scene fills the picture, or the `window` does, in lengths of the scene: (lowest (2,), highest (2,))
    right and up from where the origin is seen.
    """
    width, height = size
    if min(width, height) < 1:
        raise ValueError(f"size: {size}; a width and a height of at least one pixel are needed")
    low, high = window_of(bodies, cell, view) if window is None else window
    camera = camera_of(view)
    seen = surfaces(*bodies, camera)
    middle, pixel = (low + high) / 2, MARGIN * max((high - low) / (width, height)) / RAYS
    left, top = middle + np.array([-width, height]) * RAYS * pixel / 2
    camera_map = empty_map((height * RAYS, width * RAYS), left, top, pixel)
    draw_bodies(camera_map, seen)
    for start, end in [] if cell is None else cell_edges(cell) @ camera.T:
        draw_segment(camera_map, start, end, max(1.0, max(width, height) / 550) * RAYS * pixel)
    samples, number = visible_samples(camera_map, seen, RAYS)
    diffuse, gloss = light_on(samples, bodies, camera).T
    shade = paint[samples.body] * diffuse[:, None] + GLOSS * gloss[:, None]
    picture = np.empty((height, width, 3))
    develop(picture, number, np.minimum(shade, 1.0), 1.0, EDGE_SHADE, RAYS)
    return colours.encoded(picture)


def camera_of(view):
    """The frame of someone who looks from the direction `view`, with z up."""
    if not 0 < np.linalg.norm(view) < np.inf:
        raise ValueError(f"view: {view}; a direction of three numbers, not all zero, is needed")
    return frame_towards(view, up=(0.0, 0.0, 1.0))


def window_of(bodies: Bodies, cell, view):
    """The part of the view that bodies and cell take up: (lowest (2,), highest (2,))."""
    camera = camera_of(view)
    seen = surfaces(*bodies, camera)
    edges = np.empty((0, 2)) if cell is None else (cell_edges(cell) @ camera.T)[..., :2].reshape(-1, 2)
    corners = np.concatenate([seen.center[:, :2] - seen.extent, seen.center[:, :2] + seen.extent, edges])
    return corners.min(axis=0), corners.max(axis=0)


def joined(window, other):
    """The smallest window that has both; None is an empty one."""
    return other if window is None else (np.minimum(window[0], other[0]), np.maximum(window[1], other[1]))


def cell_edges(cell):
    """The twelve edges of the cell (3, 3), from its corner at the origin: (12, 2, 3) start and end."""
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    pairs = [(a, b) for a, b in itertools.combinations(range(8), 2) if np.abs(corners[a] - corners[b]).sum() == 1]
    return (corners @ cell)[np.array(pairs)]
