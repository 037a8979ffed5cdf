"""Grids of cells that hold the bodies by their anchors, and the search for those near a place.

Bodies are sorted into levels by the radius of their neighbourhood, a factor of two apart at most, each level with a grid of its own: a
small body looks for large ones in wide cells and a large one for small ones in narrow cells. What tells how near a body is stands with the
cell, in columns of float32: `sieve.py` asks a whole cell at once.
"""

from math import floor, sqrt

from ccd.compiling import kernel
from ccd.separation import support
from ccd.vectors import load, scale
from edmd.boundary import displaced, fraction
from edmd.prefetch import fetch_cell
from edmd.sieve import clear, hull, keep, move, sift
from edmd.state import ANCHOR_POSITION, FIRST_CELL, LANES, LEVEL, PLACE_GAP

NOWHERE = -1


@kernel
def place(cells, grid, body, kind, anchor):
    """Put a body where its anchor is now. -> whether its cell had room; else it is in none."""
    level, position = int(kind[LEVEL]), load(anchor, ANCHOR_POSITION)
    layers, f = cells.levels[level], fraction(position, grid.inverse)
    i, j, k = _layer(f[0], layers[0]), _layer(f[1], layers[1]), _layer(f[2], layers[2])
    cell = layers[FIRST_CELL] + (i * layers[1] + j) * layers[2] + k
    where = cells.where[body]
    if where[0] != cell:
        if where[0] != NOWHERE:
            _take_out(cells, body)
        if cells.count[cell] == cells.bodies.shape[1]:
            return False
        where[0], where[1] = cell, cells.count[cell]
        cells.bodies[cell, where[1]] = body
        cells.count[cell] += 1
    unit = 1.0 / cells.reaches[level, 0]
    keep(cells.places[cell], where[1], scale(unit, from_corner(grid, layers, (i, j, k), position)), hull(anchor, kind, unit))
    return True


@kernel
def _layer(f, layers):
    return min(max(int(f * layers), 0), layers - 1)


@kernel
def _take_out(cells, body):
    """The last body of the cell takes the place."""
    cell, slot = cells.where[body, 0], cells.where[body, 1]
    cells.where[body, 0] = NOWHERE
    cells.count[cell] -= 1
    last = cells.count[cell]
    if slot != last:
        moved = cells.bodies[cell, last]
        cells.bodies[cell, slot], cells.where[moved, 1] = moved, slot
        move(cells.places[cell], last, slot)
    clear(cells.places[cell], last)


@kernel
def from_corner(grid, layers, at, position):
    """A position as seen from the corner of a cell, which may lie beyond the box."""
    return displaced(position, grid.box, -at[0] / layers[0], -at[1] / layers[1], -at[2] / layers[2])


@kernel
def window(grid, layers, f, reaches):
    """The first and the last layer in each direction, beyond the box as well, that far from a place with fractional coordinates f."""
    a, b = _span(layers[0], grid.heights[0], f[0], reaches[0])
    c, d = _span(layers[1], grid.heights[1], f[1], reaches[1])
    e, g = _span(layers[2], grid.heights[2], f[2], reaches[2])
    return (a, c, e), (b, d, g)


@kernel
def extent_along(grid, s):
    """How far a body of these semi-axis vectors reaches across the faces of the cell, in each of the three directions."""
    inverse, heights = grid.inverse, grid.heights
    return (heights[0] * support(s, (inverse[0, 0], inverse[1, 0], inverse[2, 0])),
            heights[1] * support(s, (inverse[0, 1], inverse[1, 1], inverse[2, 1])),
            heights[2] * support(s, (inverse[0, 2], inverse[1, 2], inverse[2, 2])))


@kernel
def _span(layers, height, f, reach):
    here, far = f * layers, reach * layers / height
    return int(floor(here - far)), int(floor(here + far))


@kernel
def row_within(grid, layers, f, at, reach, ends):
    """The first and the last of the cells (at, k) that can hold anything within reach of f, of those between the ends."""
    a, b = _beside(layers[0], grid.heights[0], f[0], at[0]), _beside(layers[1], grid.heights[1], f[1], at[1])
    left = reach * reach / grid.heights[3] - a * a - b * b
    if left < 0.0:
        return 0, -1
    first, last = _span(layers[2], grid.heights[2], f[2], sqrt(left))
    return max(first, ends[0]), min(last, ends[1])


@kernel
def _beside(layers, height, f, layer):
    """Distance of a place from a layer of cells."""
    here = f * layers
    return max(layer - here, here - layer - 1, 0.0) * (height / layers)


@kernel
def scan(cells, grid, level, at, position, own, lengths, found):
    """Add to the hits the bodies of a cell, or of an image of it, that may be near a body there with this `hull`. -> how many hits.

    lengths: see `sift`.
    """
    layers = cells.levels[level]
    i, shift_i = _wrapped(at[0], layers[0])
    j, shift_j = _wrapped(at[1], layers[1])
    k, shift_k = _wrapped(at[2], layers[2])
    cell, image = layers[FIRST_CELL] + (i * layers[1] + j) * layers[2] + k, packed(shift_i, shift_j, shift_k)
    fetch_cell(cells, min(cell + layers[2], len(cells.count) - 1))      # beside it in the next row, which comes soon
    x = scale(1.0 / cells.reaches[level, 0], from_corner(grid, layers, at, position))
    count = cells.count[cell]
    for first in range(0, count, LANES):
        block = cells.places[cell, first // LANES]
        if sift(block, x, own, lengths):
            for lane in range(LANES):                                       # no jump: who is near is a toss
                cells.hits[found] = image | int(cells.bodies[cell, first + lane])
                found += 1 if block[PLACE_GAP + lane] <= 0.0 else 0
    return found


@kernel
def packed(i, j, k):
    """An image as the upper half of a number whose lower half is a body."""
    return ((i + 512) << 52) | ((j + 512) << 42) | ((k + 512) << 32)


@kernel
def unpacked(hit):
    """Body and image of a hit."""
    hit = int(hit)
    return hit & 0xFFFFFFFF, (hit >> 52) - 512, ((hit >> 42) & 1023) - 512, ((hit >> 32) & 1023) - 512


@kernel
def _wrapped(layer, layers):
    """The layer inside the box, and the image it belongs to. Additions: layers are few, and a division costs more."""
    shift = 0
    while layer < 0:
        layer += layers
        shift -= 1
    while layer >= layers:
        layer -= layers
        shift += 1
    return layer, shift
