"""Neighbour lists that follow the shape (docs/theory.md, section 4).

Each body has an anchor: its pose when its list was made, with a margin. It stays inside the anchor shape grown by the margin until its
ESCAPE_TIME. Two bodies are neighbours when the gap between their anchors is below the sum of their margins: so nothing outside the list
can be touched before the escape. One body at a time is looked at again, and the predictions of the pairs that stay are kept.
"""

from math import asin, floor, inf, sqrt

from ccd.compiling import kernel
from ccd.separation import best_plane, normal, shape_matrix, support
from ccd.tolerances import COARSE
from ccd.vectors import dot, load, norm, scale, store, subtract
from edmd.boundary import displaced, fraction, image_of
from edmd.events import Ended
from edmd.flight import advance, load_quaternion, load_vectors
from edmd.prediction import flight_now, hold, size_now, span_without_contact
from edmd.state import (
    ANCHOR_MARGIN,
    ANCHOR_ORIENTATION,
    ANCHOR_POSITION,
    ANCHOR_RADIUS,
    ANCHOR_SIZE,
    ANCHOR_VECTORS,
    BODY_A,
    BODY_B,
    ESCAPE_TIME,
    FREE_PAIRS,
    GROWTH,
    HORIZON,
    LARGEST,
    MARGIN_LENGTH,
    NORMAL,
    NOW,
    ORIENTATION,
    PENCIL,
    POSITION,
    REACH,
    REACH_SIZE,
    REBUILDS,
    SHIFT,
    SLOT_A,
    SPREAD,
    TURNING,
    VECTORS,
    VELOCITY,
)
from edmd.tolerances import REBUILD_BEYOND, SAFE, SURELY_NEAR

DONE, LIST_FULL, CELL_TOO_SMALL = -1, int(Ended.LIST_FULL), int(Ended.CELL_TOO_SMALL)


@kernel
def displacement(row, anchor, size):
    """How far any support value can have come from its anchor's, eq. (6): path, turning and growth. inf for a body never anchored."""
    q, p = load_quaternion(row, ORIENTATION), load_quaternion(anchor, ANCHOR_ORIENTATION)
    cosine = q[0] * p[0] + q[1] * p[1] + q[2] * p[2] + q[3] * p[3]
    angle = 2 * asin(min(1.0, sqrt(max(0.0, 1 - cosine * cosine))))
    path = norm(subtract(load(row, POSITION), load(anchor, ANCHOR_POSITION)))
    return path + angle * row[SPREAD] * max(size, anchor[ANCHOR_SIZE]) + abs(size - anchor[ANCHOR_SIZE]) * row[LARGEST]


@kernel
def set_escape(world, body):
    """The time until which an up-to-date body certainly stays within its margin."""
    row, anchor, clock = world.bodies[body], world.anchors[body], world.clock
    size = size_now(clock)
    left = SAFE * anchor[ANCHOR_MARGIN] - displacement(row, anchor, size)
    turning = norm(load(row, TURNING)) * row[SPREAD] * (size + abs(clock[GROWTH]) * clock[HORIZON])
    speed = norm(load(row, VELOCITY)) + turning + abs(clock[GROWTH]) * row[LARGEST]
    span = max(left, 0.0) / speed if speed > 0 else inf
    anchor[ESCAPE_TIME] = clock[NOW] + min(span, clock[HORIZON])


@kernel
def escape(world, body):
    """The body may have left its margin: extend its time, or make its list anew. -> DONE, LIST_FULL or CELL_TOO_SMALL."""
    row, anchor = world.bodies[body], world.anchors[body]
    advance(row, world.clock[NOW])
    if displacement(row, anchor, size_now(world.clock)) > REBUILD_BEYOND * anchor[ANCHOR_MARGIN]:
        status = rebuild(world, body)
        if status != DONE:
            return status
    set_escape(world, body)
    return DONE


@kernel
def rebuild(world, body):
    """Anchor the body where it is now and make its list: drop the pairs that have come apart, find the new ones."""
    world.tally[REBUILDS] += 1
    _anchor(world, body)
    for slot in range(world.lists.count[body] - 1, -1, -1):
        if not _near(world, world.lists.pair[body, slot], True):
            _remove(world, world.lists.pair[body, slot])
    status = _search(world, body)
    if status != DONE:
        world.anchors[body, ANCHOR_POSITION] = inf        # the list is not complete: the next escape makes it again
    return status


@kernel
def _anchor(world, body):
    """Wrap the body into the cell and store its pose, size and margin; move it to its grid cell."""
    row, anchor, grid, pairs = world.bodies[body], world.anchors[body], world.grid, world.pairs
    a, b, c = image_of(load(row, POSITION), grid.inverse)
    if a != 0 or b != 0 or c != 0:
        store(row, POSITION, displaced(load(row, POSITION), grid.box, -a, -b, -c))
        world.image[body, 0] += a
        world.image[body, 1] += b
        world.image[body, 2] += c
        for slot in range(world.lists.count[body]):
            link = pairs.link[world.lists.pair[body, slot]]
            sign = -1 if link[BODY_A] == body else 1
            link[SHIFT] += sign * a
            link[SHIFT + 1] += sign * b
            link[SHIFT + 2] += sign * c
    size = size_now(world.clock)
    store(anchor, ANCHOR_POSITION, load(row, POSITION))
    for k in range(9):
        anchor[ANCHOR_VECTORS + k] = size * row[VECTORS + k]
    for k in range(4):
        anchor[ANCHOR_ORIENTATION + k] = row[ORIENTATION + k]
    anchor[ANCHOR_SIZE] = size
    anchor[ANCHOR_MARGIN] = size * row[MARGIN_LENGTH]
    anchor[ANCHOR_RADIUS] = size * (row[LARGEST] + row[MARGIN_LENGTH])
    world.clock[REACH_SIZE] = max(size, world.clock[REACH_SIZE])
    _place(grid, body, load(row, POSITION))


@kernel
def _place(grid, body, position):
    i, j, k = grid_cell(grid, position)
    cell = (i * grid.shape[1] + j) * grid.shape[2] + k
    if grid.cell[body] == cell:
        return
    if grid.cell[body] >= 0:
        other = grid.first[grid.cell[body]]
        if other == body:
            grid.first[grid.cell[body]] = grid.following[body]
        else:
            while grid.following[other] != body:
                other = grid.following[other]
            grid.following[other] = grid.following[body]
    grid.following[body] = grid.first[cell]
    grid.first[cell] = body
    grid.cell[body] = cell


@kernel
def grid_cell(grid, position):
    f = fraction(position, grid.inverse)
    i = min(max(int(f[0] * grid.shape[0]), 0), grid.shape[0] - 1)
    j = min(max(int(f[1] * grid.shape[1]), 0), grid.shape[1] - 1)
    k = min(max(int(f[2] * grid.shape[2]), 0), grid.shape[2] - 1)
    return i, j, k


@kernel
def _near(world, pair, known):
    """Whether the gap between two anchors is below the sum of their margins, as far as the best plane tells.

    Cheap planes come first: of a known pair its last one, which settles the very near, of a new one those across the line of centres and of
    two spheres, which settle the far. The plane that decides is kept.
    """
    link, plane = world.pairs.link[pair], world.pairs.plane[pair]
    a, b = world.anchors[link[BODY_A]], world.anchors[link[BODY_B]]
    apart = subtract(load(b, ANCHOR_POSITION), load(a, ANCHOR_POSITION))
    r = displaced(apart, world.grid.box, link[SHIFT], link[SHIFT + 1], link[SHIFT + 2])
    s_a, s_b = load_vectors(a, ANCHOR_VECTORS), load_vectors(b, ANCHOR_VECTORS)
    margins = a[ANCHOR_MARGIN] + b[ANCHOR_MARGIN]
    if known:
        n = load(plane, NORMAL)
        if _plane_gap(n, r, s_a, s_b) < SURELY_NEAR * margins:
            return True
    else:
        if _plane_gap(scale(1.0 / norm(r), r), r, s_a, s_b) >= margins:
            return False
        plane[PENCIL] = a[ANCHOR_MARGIN] / margins
        n = normal(shape_matrix(s_a), shape_matrix(s_b), r, plane[PENCIL])
        if _plane_gap(n, r, s_a, s_b) >= margins:
            return False
    n, plane[PENCIL], _ = best_plane(s_a, s_b, r, plane[PENCIL], COARSE)
    store(plane, NORMAL, n)
    return _plane_gap(n, r, s_a, s_b) < margins


@kernel
def _plane_gap(n, r, s_a, s_b):
    return dot(n, r) - support(s_a, n) - support(s_b, n)


@kernel
def _listed(world, body, other, shift):
    """Whether the pair of the body with this image of the other is in its list."""
    lists = world.lists
    for slot in range(lists.count[body]):
        if lists.partner[body, slot] == other:
            link = world.pairs.link[lists.pair[body, slot]]
            sign = 1 if link[BODY_A] == body else -1
            if link[SHIFT] == sign * shift[0] and link[SHIFT + 1] == sign * shift[1] and link[SHIFT + 2] == sign * shift[2]:
                return True
    return False


@kernel
def _search(world, body):
    """Look through the grid cells within reach, each image once, for neighbours that are not listed yet."""
    grid, anchor = world.grid, world.anchors[body]
    reach = anchor[ANCHOR_RADIUS] + world.clock[REACH] * world.clock[REACH_SIZE]
    f = fraction(load(anchor, ANCHOR_POSITION), grid.inverse)
    left = reach * reach / grid.heights[3]
    for i in _layers(grid, 0, f[0], left):
        ci, shift_i = _wrapped(i, grid.shape[0])
        left_i = left - _beside(grid, 0, f[0], i)
        for j in _layers(grid, 1, f[1], left_i):
            cj, shift_j = _wrapped(j, grid.shape[1])
            for k in _layers(grid, 2, f[2], left_i - _beside(grid, 1, f[1], j)):
                ck, shift_k = _wrapped(k, grid.shape[2])
                status = _search_cell(world, body, (ci * grid.shape[1] + cj) * grid.shape[2] + ck, (shift_i, shift_j, shift_k))
                if status != DONE:
                    return status
    return DONE


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


@kernel
def _layers(grid, side, f, squared):
    """The layers of cells, beyond the box as well, within a squared distance of the fractional coordinate f in this direction."""
    per_length = grid.shape[side] / grid.heights[side]
    here, far = f * grid.shape[side], sqrt(max(squared, 0.0)) * per_length
    return range(int(floor(here - far)), int(floor(here + far)) + 1)


@kernel
def _beside(grid, side, f, cell):
    """Squared distance of a point from a layer of cells."""
    here = f * grid.shape[side]
    outside = max(cell - here, here - cell - 1, 0.0) * (grid.heights[side] / grid.shape[side])
    return outside * outside


@kernel
def _search_cell(world, body, cell, shift):
    anchors = world.anchors
    image = displaced((0.0, 0.0, 0.0), world.grid.box, shift[0], shift[1], shift[2])
    here = subtract(load(anchors[body], ANCHOR_POSITION), image)
    other = int(world.grid.first[cell])
    while other >= 0:
        r = subtract(load(anchors[other], ANCHOR_POSITION), here)
        within = anchors[body, ANCHOR_RADIUS] + anchors[other, ANCHOR_RADIUS]
        if dot(r, r) < within * within:
            itself = other == body and shift[0] == 0 and shift[1] == 0 and shift[2] == 0
            if not itself and not _listed(world, body, other, shift):
                status = _consider(world, body, other, shift)
                if status != DONE:
                    return status
        other = int(world.grid.following[other])
    return DONE


@kernel
def _consider(world, body, other, shift):
    """Add the pair if its anchors are near. The new row is written first and taken for good only then."""
    lists, pairs, tally = world.lists, world.pairs, world.tally
    if tally[FREE_PAIRS] == 0:
        return LIST_FULL
    pair = pairs.free[tally[FREE_PAIRS] - 1]
    link = pairs.link[pair]
    link[BODY_A], link[BODY_B] = body, other
    link[SHIFT], link[SHIFT + 1], link[SHIFT + 2] = shift
    if not _near(world, pair, False):
        return DONE
    if body == other:
        return CELL_TOO_SMALL
    slot_a, slot_b = lists.count[body], lists.count[other]
    if max(slot_a, slot_b) == lists.pair.shape[1]:
        return LIST_FULL
    tally[FREE_PAIRS] -= 1
    link[SLOT_A], link[SLOT_A + 1] = slot_a, slot_b
    lists.count[body] += 1
    lists.count[other] += 1
    lists.pair[body, slot_a] = lists.pair[other, slot_b] = pair
    lists.partner[body, slot_a], lists.partner[other, slot_b] = other, body
    hold(world, body, slot_a, world.clock[NOW] + span_without_contact(world, flight_now(world.bodies[body], world.clock), body, slot_a))
    return DONE


@kernel
def _remove(world, pair):
    link = world.pairs.link[pair]
    _vacate(world, link[BODY_A], link[SLOT_A])
    _vacate(world, link[BODY_B], link[SLOT_A + 1])
    world.pairs.free[world.tally[FREE_PAIRS]] = pair
    world.tally[FREE_PAIRS] += 1


@kernel
def _vacate(world, body, slot):
    """Take a slot out of a list: the last one moves there."""
    lists = world.lists
    last = lists.count[body] - 1
    lists.count[body] = last
    if slot == last:
        return
    moved = lists.pair[body, last]
    lists.pair[body, slot] = moved
    lists.partner[body, slot] = lists.partner[body, last]
    lists.time[body, slot] = lists.time[body, last]
    link = world.pairs.link[moved]
    link[SLOT_A if link[BODY_A] == body else SLOT_A + 1] = slot
