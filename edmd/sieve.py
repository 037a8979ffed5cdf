"""Which bodies of a cell may be near a body: two cheap planes, in float32, for several bodies with one instruction (theory, eq. (6b)).

A body is taken for its hull, the least body of revolution about one of its axes that holds it: the body itself, if it is one of revolution.
Lengths are in units of the level of the cell, so that no square leaves the range of float32.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from ccd.compiling import kernel
from ccd.revolution import shape_of_axis
from ccd.separation import adjugate_times
from ccd.vectors import dot, load, norm, scale, subtract
from edmd.state import (
    ANCHOR_MARGIN,
    ANCHOR_SIZE,
    ANCHOR_VECTORS,
    HULL,
    HULL_ACROSS,
    HULL_ALONG,
    LANES,
    NOBODY,
    PLACE_ACROSS,
    PLACE_ALONG,
    PLACE_AXIS,
    PLACE_GAP,
    PLACE_MARGIN,
    PLACE_POSITION,
    SEMI_AXES,
)
from edmd.tolerances import FLOAT32_SLACK, NARROW


class Hull(NamedTuple):
    """A body of revolution and its margin, in float32."""

    axis: tuple             # unit vector
    across: np.float32      # squared semi-axis
    along: np.float32       # squared semi-axis
    margin: np.float32
    narrow: bool            # whether the second plane is worth it


@kernel
def hull(anchor, kind, unit):
    """That of a body as its anchor has it. unit: a factor on lengths."""
    pole, size = int(kind[HULL]), unit * anchor[ANCHOR_SIZE]
    axis = scale(1.0 / (anchor[ANCHOR_SIZE] * kind[SEMI_AXES + pole]), load(anchor, ANCHOR_VECTORS + 3 * pole))
    square = size * size
    across, along = square * kind[HULL_ACROSS], square * kind[HULL_ALONG]
    narrow = along > NARROW * across or across > NARROW * along
    return Hull(_single(axis), np.float32(across), np.float32(along), np.float32(unit * anchor[ANCHOR_MARGIN]), narrow)


@kernel
def _single(x):
    return np.float32(x[0]), np.float32(x[1]), np.float32(x[2])


@kernel
def keep(blocks, slot, position, own):
    """Write a body with this hull into its slot of a cell. position: from the corner of the cell."""
    block, lane = blocks[slot // LANES], slot % LANES
    for k in range(3):
        block[PLACE_POSITION + k * LANES + lane] = position[k]
        block[PLACE_AXIS + k * LANES + lane] = own.axis[k]
    block[PLACE_ACROSS + lane], block[PLACE_ALONG + lane], block[PLACE_MARGIN + lane] = own.across, own.along, own.margin


@kernel
def move(blocks, source, target):
    """Put a body into another slot of its cell."""
    for column in range(0, PLACE_GAP, LANES):
        blocks[target // LANES, column + target % LANES] = blocks[source // LANES, column + source % LANES]


@kernel
def clear(blocks, slot):
    """Leave a slot to nobody: a place too far to be near."""
    blocks[slot // LANES, PLACE_POSITION + slot % LANES] = NOBODY


@kernel
def sift(block, position, own, lengths):
    """Tell which bodies of a block may be neighbours of a body with this hull there: those with no PLACE_GAP above 0. -> whether any is.

    lengths: sum of all that are rounded, but position.
    """
    x, near = _single(position), False
    slack = np.float32(FLOAT32_SLACK * (abs(position[0]) + abs(position[1]) + abs(position[2]) + lengths))
    for lane in range(LANES):
        r, other = _seen(block, lane, x)
        block[PLACE_GAP + lane] = _gap(r, r, own, other, own.margin + other.margin + slack)
        near |= block[PLACE_GAP + lane] <= 0
    if near and own.narrow:
        for lane in range(LANES):
            r, other = _seen(block, lane, x)
            block[PLACE_GAP + lane] = max(block[PLACE_GAP + lane],
                                          _gap(_normal(r, own, other), r, own, other, own.margin + other.margin + slack))
    return near


@kernel
def _seen(block, lane, x):
    """A body of a block, as seen from x."""
    position, axis = _three(block, PLACE_POSITION + lane), _three(block, PLACE_AXIS + lane)
    return subtract(position, x), Hull(axis, block[PLACE_ACROSS + lane], block[PLACE_ALONG + lane], block[PLACE_MARGIN + lane], False)


@kernel
def _three(block, start):
    return block[start], block[start + LANES], block[start + 2 * LANES]


@kernel
def _gap(n, r, a, b, within):
    """How far two hulls are apart in direction n, of any length, beyond a distance; times that length."""
    return dot(n, r) - _support(a, n) - _support(b, n) - within * norm(n)


@kernel
def _support(hull, n):
    """Of a direction of any length; a sum of squares as in (7f), which plates need."""
    c = dot(hull.axis, n)
    across = subtract(n, scale(c, hull.axis))
    return sqrt(hull.across * dot(across, across) + hull.along * (c * c))


@kernel
def _normal(r, a, b):
    """Some multiple of that of the pencil (4) in the ratio of the margins: divided by a trace, so that its square is in range."""
    x_a, x_b = shape_of_axis(a.axis, a.across, a.along), shape_of_axis(b.axis, b.across, b.along)
    over = np.float32(1.0) / (b.margin * (x_a[0] + x_a[1] + x_a[2]) + a.margin * (x_b[0] + x_b[1] + x_b[2]))
    y, x = over * b.margin, over * a.margin
    return adjugate_times((y * x_a[0] + x * x_b[0], y * x_a[1] + x * x_b[1], y * x_a[2] + x * x_b[2],
                           y * x_a[3] + x * x_b[3], y * x_a[4] + x * x_b[4], y * x_a[5] + x * x_b[5]), r)
