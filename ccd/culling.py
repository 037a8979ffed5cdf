"""Which pairs of many bodies can touch at all: bounding spheres (paper, Sec. 4.1), with periodic images."""

import numpy as np
from scipy.spatial import cKDTree

from ccd.checks import real_array


def close_pairs(centers, radii, box=None, gap=0.0):
    """Pairs whose bounding spheres come closer than a gap.

    centers (n, 3), radii (n,), box (3, 3) with the cell vectors as rows or None for no periodicity. -> first (p,), second (p,), and
    offset (p, 3) from the centre of the first to that of the image of the second. Every pair of images is listed once, pairs of a body
    with its own image included (then first == second).
    """
    centers = real_array("centers", centers, (None, 3), "an array (n, 3)")
    radii = real_array("radii", np.broadcast_to(radii, (len(centers),)), (len(centers),), f"one number or ({len(centers)},)")
    if len(centers) == 0:
        return np.empty(0, dtype=int), np.empty(0, dtype=int), np.empty((0, 3))
    owners, images, home = np.arange(len(centers)), centers, np.ones(len(centers), dtype=bool)
    if box is not None:
        owners, images, home, centers = _images(centers, real_array("box", box, (3, 3), "three cell vectors as rows"),
                                                2 * radii.max() + gap)
    near = cKDTree(centers).query_ball_tree(cKDTree(images), 2 * radii.max() + gap)
    first = np.repeat(np.arange(len(centers)), [len(group) for group in near])
    image = np.concatenate([np.asarray(group, dtype=int) for group in near])
    second = owners[image]
    offset = images[image] - centers[first]
    distance = np.sqrt((offset**2).sum(axis=1))
    itself = (first == second) & home[image]
    once = (first < second) | ((first == second) & (_sign(offset) > 0))
    keep = once & ~itself & (distance < radii[first] + radii[second] + gap)
    return first[keep], second[keep], offset[keep]


def _sign(offset):
    """The sign of the first coordinate that is not zero: picks one of the two images +s and -s of a body."""
    x, y, z = offset.T
    return np.where(x != 0, np.sign(x), np.where(y != 0, np.sign(y), np.sign(z)))


def _images(centers, box, reach):
    """Every image within reach of the home cell: owner, centre, whether it is the home one; and the centres inside the home cell."""
    fraction = centers @ np.linalg.inv(box)
    heights = 1 / np.sqrt((np.linalg.inv(box)**2).sum(axis=0))
    margin = reach / heights
    fraction = fraction - np.floor(fraction)
    cells = [np.arange(-int(np.ceil(m)), int(np.ceil(m)) + 1) for m in margin]
    shifts = np.stack(np.meshgrid(*cells, indexing="ij"), axis=-1).reshape(-1, 3)
    owners, images, home = [], [], []
    for shift in shifts:
        inside = ((fraction + shift > -margin) & (fraction + shift < 1 + margin)).all(axis=1)
        owners.append(np.flatnonzero(inside))
        images.append((fraction[inside] + shift) @ box)
        home.append(np.full(inside.sum(), not shift.any()))
    return np.concatenate(owners), np.concatenate(images), np.concatenate(home), fraction @ box
