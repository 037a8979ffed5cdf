"""Which body does each pixel of a view show, and how near is it? Exact rays against ellipsoids, all rays parallel.

A view is an orthonormal, right-handed frame (3, 3) whose rows are right, up and towards the viewer.
"""

from typing import NamedTuple

import numpy as np

from ccd.compiling import kernel
from ccd.quaternions import rotation_matrices

BACKGROUND, EDGE = -1, -2


class Surfaces(NamedTuple):
    """Ellipsoids in the coordinates of a view: X^T A X = 1 about each center."""

    center: np.ndarray  # (n, 3)
    quadric: np.ndarray  # (n, 6): A as xx, yy, zz, xy, xz, yz
    extent: np.ndarray  # (n, 2): half the width and the height of the silhouette's box


class DepthMap(NamedTuple):
    """What a view sees: of each pixel, the height towards the viewer and the body that is there, BACKGROUND or EDGE."""

    depth: np.ndarray  # (rows, columns), -inf where nothing is
    body: np.ndarray  # (rows, columns) int32
    left: float  # view coordinates of the outer corner of pixel (0, 0): row 0 is the top
    top: float
    pixel: float  # side of a pixel


def surfaces(positions, orientations, semi_axes, view):
    """The ellipsoids as `view` has them."""
    axes = view @ rotation_matrices(orientations)  # columns: the body's axes in view coordinates
    quadric = np.einsum("nij,nj,nkj->nik", axes, semi_axes**-2.0, axes)
    covariance = np.einsum("nij,nj,nij->ni", axes, semi_axes**2.0, axes)
    six = np.stack([quadric[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))], axis=1)
    return Surfaces(positions @ view.T, six, np.ascontiguousarray(np.sqrt(covariance[:, :2])))


def empty_map(shape, left, top, pixel):
    """A depth map that shows nothing yet."""
    return DepthMap(np.full(shape, -np.inf), np.full(shape, BACKGROUND, dtype=np.int32), left, top, pixel)


@kernel
def span(low, high, corner, pixel, count):
    """First and one past the last of the pixels whose centers lie in [low, high]."""
    first = int(np.ceil((low - corner) / pixel - 0.5))
    last = int(np.floor((high - corner) / pixel - 0.5)) + 1
    return max(first, 0), min(last, count)


@kernel
def draw_bodies(view_map, bodies):
    """Draw the ellipsoids into the map, nearest wins: each pixel's own ray meets each surface exactly."""
    rows, columns = view_map.depth.shape
    for i in range(len(bodies.center)):
        cx, cy, cz = bodies.center[i]
        xx, yy, zz, xy, xz, yz = bodies.quadric[i]
        width, height = bodies.extent[i]
        first_row, last_row = span(view_map.top - cy - height, view_map.top - cy + height, 0.0, view_map.pixel, rows)
        first_column, last_column = span(cx - width, cx + width, view_map.left, view_map.pixel, columns)
        for row in range(first_row, last_row):
            y = view_map.top - (row + 0.5) * view_map.pixel - cy
            for column in range(first_column, last_column):
                x = view_map.left + (column + 0.5) * view_map.pixel - cx
                half = xz * x + yz * y
                discriminant = half * half - zz * (xx * x * x + 2.0 * xy * x * y + yy * y * y - 1.0)
                if discriminant >= 0.0:
                    depth = cz + (np.sqrt(discriminant) - half) / zz
                    if depth > view_map.depth[row, column]:
                        view_map.depth[row, column] = depth
                        view_map.body[row, column] = i


@kernel
def draw_segment(view_map, start, end, width):
    """Draw a straight line of the given width between two points of the view, where nothing is nearer."""
    rows, columns = view_map.depth.shape
    dx, dy = end[0] - start[0], end[1] - start[1]
    length2 = max(dx * dx + dy * dy, 1e-300)
    margin = 0.5 * width
    low, high = min(start[0], end[0]) - margin, max(start[0], end[0]) + margin
    first_column, last_column = span(low, high, view_map.left, view_map.pixel, columns)
    low, high = view_map.top - max(start[1], end[1]) - margin, view_map.top - min(start[1], end[1]) + margin
    first_row, last_row = span(low, high, 0.0, view_map.pixel, rows)
    for row in range(first_row, last_row):
        y = view_map.top - (row + 0.5) * view_map.pixel - start[1]
        for column in range(first_column, last_column):
            x = view_map.left + (column + 0.5) * view_map.pixel - start[0]
            along = min(max((x * dx + y * dy) / length2, 0.0), 1.0)
            off_x, off_y = x - along * dx, y - along * dy
            depth = start[2] + along * (end[2] - start[2])
            if off_x * off_x + off_y * off_y <= margin * margin and depth > view_map.depth[row, column]:
                view_map.depth[row, column] = depth
                view_map.body[row, column] = EDGE
