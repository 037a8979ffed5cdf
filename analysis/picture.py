"""What does the packing look like? A picture for a paper, by exact rays, without a display."""

import itertools
import os

import MDAnalysis as mda
import numpy as np

from analysis import colours
from analysis.raycasting import draw_bodies, draw_segment, empty_map, surfaces
from analysis.shading import GLOSS, develop, frame_towards, light_on, visible_samples
from ccd.contacts import contact_numbers, contact_pairs, rattlers

RAYS = 3  # rays a side of a pixel
MARGIN = 1.03
EDGE_SHADE = 0.02


def render(source, output, frame=-1, colour="orientation", size=(900, 900), view=(0.42, -1.0, 0.36), cell=True, contact_gap=1e-5):
    """Draw one frame of a run into a PNG file.

    `source` is the path of an edmd file, or a Universe of one, whose current frame stays as it is; `frame` its number,
    negative from the end. `colour`: "orientation", "species" or "contacts" (of a gap mu - 1
    below `contact_gap`; see analysis.colours). `size` is (width,
    height) in pixels; `view` the direction from which one looks, in the lab, with z up; `cell` draws the edges of the
    periodic cell. Every body is drawn whole, its center inside the cell. Returns the path written. ValueError for any other
    colour, a frame that is not there, a size below one pixel or a view of length zero.
    """
    if colour not in ("orientation", "species", "contacts"):
        raise ValueError(f'colour: {colour!r}; "orientation", "species" or "contacts" is needed')
    from matplotlib.image import imsave

    opened = not isinstance(source, mda.Universe)
    universe = mda.Universe(source) if opened else source
    trajectory = universe.trajectory
    current = trajectory.frame
    try:
        if not -len(trajectory) <= frame < len(trajectory):
            raise ValueError(f"frame: {frame}; the run has {len(trajectory)}; negative counts from the end")
        data = trajectory[frame].data
        positions, orientations, semi_axes, box = (data[name] for name in ("position", "orientation", "semi_axes", "cell"))
        paint = body_colours(colour, universe.atoms, data, contact_gap)
        pixels = image((positions, orientations, semi_axes), paint, box if cell else None, size, view)
    finally:
        if opened:
            trajectory.close()
        else:
            trajectory[current]
    imsave(output, pixels)
    return os.fspath(output)


def body_colours(colour, atoms, data, contact_gap):
    """Linear RGB (n, 3) of the bodies of a frame."""
    if colour == "species":
        return colours.species_colours(atoms.types.astype(int))
    if colour == "contacts":
        pairs = contact_pairs(data["position"], data["orientation"], data["semi_axes"], data["cell"], contact_gap)
        return colours.contact_colours(contact_numbers(pairs, len(atoms)), rattlers(pairs, len(atoms)))
    return colours.orientation_colours(data["orientation"], data["semi_axes"])


def image(bodies, paint, cell=None, size=(900, 900), view=(0.42, -1.0, 0.36)):
    """The picture of ellipsoids as sRGB bytes (height, width, 3), on white, in parallel projection.

    `bodies` are (positions (n, 3), orientations (n, 4) scalar first, semi_axes (n, 3)); `paint` (n, 3) linear RGB; `cell`
    (3, 3), rows are the cell vectors, or None to draw no edges; `size` (width, height); `view` (3,) the direction from
    which one looks, with z up. The scene fills the picture.
    """
    width, height = size
    if min(width, height) < 1:
        raise ValueError(f"size: {size}; a width and a height of at least one pixel are needed")
    if not 0 < np.linalg.norm(view) < np.inf:
        raise ValueError(f"view: {view}; a direction of three numbers, not all zero, is needed")
    camera = frame_towards(view, up=(0.0, 0.0, 1.0))
    seen = surfaces(*bodies, camera)
    edges = np.empty((0, 2, 3)) if cell is None else cell_edges(cell) @ camera.T
    corners = np.concatenate([seen.center[:, :2] - seen.extent, seen.center[:, :2] + seen.extent, edges[..., :2].reshape(-1, 2)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, pixel = (low + high) / 2, MARGIN * max((high - low) / (width, height)) / RAYS
    left, top = middle + np.array([-width, height]) * RAYS * pixel / 2
    camera_map = empty_map((height * RAYS, width * RAYS), left, top, pixel)
    draw_bodies(camera_map, seen)
    for start, end in edges:
        draw_segment(camera_map, start, end, max(1.0, max(width, height) / 550) * RAYS * pixel)
    samples, number = visible_samples(camera_map, seen, RAYS)
    diffuse, gloss = light_on(samples, bodies, camera).T
    shade = paint[samples.body] * diffuse[:, None] + GLOSS * gloss[:, None]
    picture = np.empty((height, width, 3))
    develop(picture, number, np.minimum(shade, 1.0), 1.0, EDGE_SHADE, RAYS)
    return colours.encoded(picture)


def cell_edges(cell):
    """The twelve edges of the cell (3, 3), from its corner at the origin: (12, 2, 3) start and end."""
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    pairs = [(a, b) for a, b in itertools.combinations(range(8), 2) if np.abs(corners[a] - corners[b]).sum() == 1]
    return (corners @ cell)[np.array(pairs)]
