"""Pictures of ellipsoids, those in collision red, by the project's own ray caster."""

import numpy as np
from matplotlib.image import imsave
from scipy.spatial.transform import Rotation

from analysis.colours import linear_rgb
from analysis.picture import image

RED, FLOOR = (0.56, 0.20, 0.11), (0.86, 0.0, 0.01)          # OKLab
MEAN_LIGHTNESS, CONTRAST = 0.75, 0.5
FLOOR_THICKNESS = 0.01


def scene(bodies, colours, colliding, view, size, floor=None):
    """A picture as sRGB bytes (height, width, 3).

    `bodies`: (centers (n, 3), orientations (n, 4), semi_axes (n, 3)); `colours` (n, 3) in OKLab; `colliding`: numbers of the bodies to be
    drawn red; `view` the direction from which one looks; `size` (width, height); `floor`: (x, y, z, radius) of a
    round one.
    """
    paint = np.array(colours, dtype=float)
    red = list(colliding)
    lighter = CONTRAST * (paint[red, 0] - MEAN_LIGHTNESS)       # two red bodies that overlap shall still be seen as two
    paint[red] = RED
    paint[red, 0] += lighter
    if floor is not None:
        x, y, z, radius = floor
        disc = ((x, y, z - FLOOR_THICKNESS), (1, 0, 0, 0), (radius, radius, FLOOR_THICKNESS))
        bodies, paint = [np.vstack([part, extra]) for part, extra in zip(bodies, disc)], np.vstack([paint, FLOOR])
    return image(tuple(bodies), linear_rgb(paint), None, size, view)


def moved(ellipsoids, motions, t):
    """Where ellipsoids stand, and what they have become, at time t of their rational or affine motions (Rest: where they are).

    -> (centers (n, 3), orientations (n, 4), semi_axes (n, 3))
    """
    centers, orientations, semi_axes = [], [], []
    for ellipsoid, motion in zip(ellipsoids, motions):
        if not hasattr(motion, "matrix"):
            poses = ellipsoid.center, ellipsoid.orientation, ellipsoid.semi_axes
        else:
            matrix = motion.matrix(t)
            axes, lengths, _ = np.linalg.svd(matrix[:3, :3] * ellipsoid.semi_axes)
            axes[:, 0] *= np.linalg.det(axes)
            poses = matrix[:3, 3], np.roll(Rotation.from_matrix(axes).as_quat(), 1), lengths
        for column, value in zip((centers, orientations, semi_axes), poses):
            column.append(value)
    return np.array(centers), np.array(orientations), np.array(semi_axes)


def save_row(pictures, path):
    """Write pictures of one size side by side into a PNG file."""
    imsave(path, np.hstack(pictures))
