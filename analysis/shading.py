"""How bright is each point of a picture? Many lamps around the scene: soft shadows and the shade in the gaps between bodies
alike.

A lamp sees the scene in parallel rays as a camera does, and a point is in its light when the lamp's own depth map shows it.
"""

from typing import NamedTuple

import numba
import numpy as np

from analysis.raycasting import draw_bodies, empty_map, surfaces
from ccd.compiling import kernel, parallel_kernel

SKY_LAMPS, KEY_LAMPS = 192, 32
KEY_DIRECTION = (-0.45, 0.62, 0.64)  # in the camera's view: from the upper left, over the viewer's shoulder
KEY_SPREAD = 0.13  # radians: softness of the shadow's edge
SKY_LIGHT, KEY_LIGHT, GLOSS = 0.68, 0.60, 0.10
LAMP_PIXELS = 384


class Samples(NamedTuple):
    """Points of surfaces that the camera sees, in its view: one for each body in each pixel."""

    point: np.ndarray  # (m, 3)
    normal: np.ndarray  # (m, 3) unit, outward
    body: np.ndarray  # (m,)


def light_on(samples, bodies, camera):
    """Light that reaches each sample from all lamps: (m, 2) diffuse, 1 about that of an open surface, and gloss.

    `bodies` are (positions, orientations, semi_axes); `camera` is the view in which the samples stand.
    """
    positions, orientations, semi_axes = bodies
    light = np.zeros((len(samples.body), 2))
    center = (positions.max(axis=0) + positions.min(axis=0)) / 2
    radius = np.linalg.norm(positions - center, axis=1).max() + semi_axes.max()
    pixel = 2 * radius / LAMP_PIXELS
    for direction, brightness in lamps():
        lamp = frame_towards(direction)
        view = lamp @ camera
        x, y, _ = view @ center
        lamp_map = empty_map((LAMP_PIXELS, LAMP_PIXELS), x - radius, y + radius, pixel)
        draw_bodies(lamp_map, surfaces(positions, orientations, semi_axes, view))
        add_light(light, samples, lamp_map, lamp, brightness, pixel)
    return light


def lamps():
    """Directions towards the lamps in the camera's view, with their brightness: an even sky, brighter above.

    And one broad key light.
    """
    sky = fibonacci_cap(SKY_LAMPS, -1.0)
    sky_light = 1 + 0.6 * sky[:, 1] + 0.3 * sky[:, 2]
    key = fibonacci_cap(KEY_LAMPS, np.cos(KEY_SPREAD)) @ frame_towards(np.array(KEY_DIRECTION))
    yield from zip(sky, 4 * SKY_LIGHT / SKY_LAMPS * sky_light)
    yield from zip(key, np.full(KEY_LAMPS, KEY_LIGHT / KEY_LAMPS))


def fibonacci_cap(n, lowest):
    """n unit vectors spread evenly over the part of the sphere with z > lowest, (n, 3)."""
    z = 1 - (1 - lowest) * (np.arange(n) + 0.5) / n
    turn = np.arange(n) * np.pi * (3 - np.sqrt(5))
    return np.column_stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])


def frame_towards(direction, up=(0.0, 1.0, 0.0)):
    """The view of someone who stands in `direction` and looks at the origin: rows right, up, towards the viewer."""
    toward = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    right = np.cross(up, toward)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross((0.0, 1.0, 0.0) if up[1] == 0 else (0.0, 0.0, -1.0), toward)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(toward, right), toward])


def visible_samples(camera_map, bodies, fine):
    """The Samples of a camera's map of fine x fine rays a pixel, and for every ray the number of its sample.

    Or what it met instead.
    """
    number = np.empty_like(camera_map.body)
    rays = np.empty(camera_map.body.size, dtype=np.int64)
    rays = rays[: share_samples(camera_map.body, number, rays, fine)]
    row, column = np.divmod(rays, camera_map.body.shape[1])
    body = camera_map.body[row, column]
    x = camera_map.left + (column + 0.5) * camera_map.pixel
    y = camera_map.top - (row + 0.5) * camera_map.pixel
    point = np.column_stack([x, y, camera_map.depth[row, column]])
    px, py, pz = (point - bodies.center[body]).T
    xx, yy, zz, xy, xz, yz = bodies.quadric[body].T
    gradient = np.column_stack([xx * px + xy * py + xz * pz, xy * px + yy * py + yz * pz, xz * px + yz * py + zz * pz])
    return Samples(point, gradient / np.linalg.norm(gradient, axis=1)[:, None], body), number


@kernel
def share_samples(body, number, rays, fine):
    """Choose one ray for each body in each pixel of fine x fine rays, put its flat index into `rays`, its place there into
    `number`.

    Within a pixel the light on one body hardly changes: sharing it saves most of the work. Returns how many were chosen.
    """
    rows, columns = body.shape
    count = 0
    for corner_row in range(0, rows, fine):
        for corner_column in range(0, columns, fine):
            first = count
            for k in range(fine * fine):
                row, column = corner_row + k // fine, corner_column + k % fine
                here = body[row, column]
                number[row, column] = here
                if here >= 0:
                    known = first
                    while known < count and body[rays[known] // columns, rays[known] % columns] != here:
                        known += 1
                    if known == count:
                        rays[count] = row * columns + column
                        count += 1
                    number[row, column] = known
    return count


@parallel_kernel
def add_light(light, samples, lamp_map, lamp, brightness, bias):
    """Add one lamp's light, diffuse and gloss, to the samples that it sees.

    `lamp` (3, 3) turns the camera's view into the lamp's.
    """
    lx, ly, lz = lamp[2]
    half = np.sqrt(2.0 + 2.0 * lz)
    for k in numba.prange(len(samples.body)):
        nx, ny, nz = samples.normal[k]
        cosine = nx * lx + ny * ly + nz * lz
        if cosine > 0.0 and is_seen(lamp_map, lamp, samples.point[k], samples.body[k], bias):
            light[k, 0] += brightness * cosine
            mirror = (cosine + nz) / half  # cosine between the normal and the half-way vector of lamp and viewer
            mirror2 = mirror * mirror
            mirror8 = mirror2 * mirror2 * mirror2 * mirror2
            light[k, 1] += brightness * mirror8 * mirror8 * mirror8 * mirror8


@kernel
def is_seen(lamp_map, lamp, point, body, bias):
    """Does the lamp see this point? Depths within `bias` count as equal, and a convex body never shades its own lit side."""
    rows, columns = lamp_map.depth.shape
    x = lamp[0, 0] * point[0] + lamp[0, 1] * point[1] + lamp[0, 2] * point[2]
    y = lamp[1, 0] * point[0] + lamp[1, 1] * point[1] + lamp[1, 2] * point[2]
    z = lamp[2, 0] * point[0] + lamp[2, 1] * point[1] + lamp[2, 2] * point[2]
    row, column = int((lamp_map.top - y) / lamp_map.pixel), int((x - lamp_map.left) / lamp_map.pixel)
    if row < 0 or column < 0 or row >= rows or column >= columns:
        return True
    return lamp_map.body[row, column] == body or lamp_map.depth[row, column] <= z + bias


@kernel
def develop(picture, number, shade, background, edge, fine):
    """Fill the picture (rows, columns, 3), linear light: the mean over each pixel's rays of the shade (m, 3) of their samples."""
    picture[:] = 0.0
    for row in range(number.shape[0]):
        for column in range(number.shape[1]):
            sample = number[row, column]
            for channel in range(3):
                value = shade[sample, channel] if sample >= 0 else (background if sample == -1 else edge)
                picture[row // fine, column // fine, channel] += value / (fine * fine)
