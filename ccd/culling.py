"""Which pairs of many bodies can touch at all: bounding spheres (paper, Sec. 4.1), with the periodic images of any cell."""

import numpy as np
from scipy.spatial import KDTree

from ccd.checks import real_array


def near_pairs(positions, cell, cutoff):
    """Every pair of bodies, or of a body and an image, that is at most `cutoff` apart: each pair of images once.

    positions (n, 3), anywhere; cell (3, 3), its rows the cell vectors, of any shape; cutoff a length, larger than the cell too: then a
    pair stands there for each of its images, and a body is paired with its own. -> first (m,), second (m,), separation (m, 3) from the
    first body to the image of the second.
    """
    reciprocal = np.linalg.inv(cell)
    fractions = positions @ reciprocal % 1.0
    inside = fractions @ cell
    reach = cutoff * np.linalg.norm(reciprocal, axis=0)         # of a cutoff, in fractions of the width between opposite faces
    steps = [np.arange(-n, n + 1) for n in np.ceil(reach).astype(int)]
    shifts = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    around = fractions + shifts[:, None]
    shift, body = np.nonzero(np.all((around >= -reach) & (around <= 1 + reach), axis=2))
    images = inside[body] + shifts[shift] @ cell
    found = KDTree(inside).sparse_distance_matrix(KDTree(images), cutoff, output_type="ndarray")
    first, image = found["i"], found["j"]
    forward = shift[image] > len(shifts) // 2       # of two opposite shifts one is in the second half; the middle is no shift
    once = (first < body[image]) | ((first == body[image]) & forward)
    first, image = first[once], image[once]
    return first, body[image], images[image] - inside[first]


def close_pairs(positions, radii, cell, gap=0.0):
    """The `near_pairs` whose bounding spheres, of radii (n,), come closer than a gap."""
    radii = real_array("radii", radii, (len(positions),), f"({len(positions)},)")
    first, second, separation = near_pairs(positions, cell, 2 * radii.max() + gap)
    close = np.sqrt((separation**2).sum(axis=1)) <= radii[first] + radii[second] + gap
    return first[close], second[close], separation[close]
