"""Neighbour lists that follow the shape (docs/theory.md, section 4).

Each body has an anchor: its pose when its list was made, with a margin. It stays inside the anchor shape grown by the margin until its
ESCAPE_TIME. Two bodies are neighbours when the gap between their anchors is below the sum of their margins: so nothing outside the list
can be touched before the escape. One body at a time is looked at again, and the predictions of the pairs that stay are kept.
"""

from math import asin, floor, inf, sqrt

from ccd.compiling import kernel
from ccd.precession import NO_AXIS
from ccd.separation import best_plane, normal, shape_matrix, support
from ccd.tolerances import COARSE
from ccd.vectors import dot, load, norm, scale, store, subtract
from edmd.boundary import displaced, fraction, image_of
from edmd.events import Ended
from edmd.flight import advance, fastest, kind_of, load_vectors
from edmd.prediction import (
    ball_now,
    direction_of,
    flight_now,
    hold,
    hold_until,
    imaged,
    is_sphere,
    meeting_of_balls,
    size_now,
)
from edmd.state import (
    ANCHOR_MARGIN,
    ANCHOR_POSITION,
    ANCHOR_RADIUS,
    ANCHOR_SIZE,
    ANCHOR_VECTORS,
    AXIS,
    BEGIN,
    COUNT,
    ENTRIES,
    ENTRY_ROW,
    ESCAPE_TIME,
    GROWTH,
    HORIZON,
    IMAGE,
    LARGEST,
    MARGIN_LENGTH,
    NOW,
    PARTNER,
    POSITION,
    REACH,
    REACH_SIZE,
    REBUILDS,
    ROOM,
    SEMI_AXES,
    SIDE,
    SPREAD,
    TWIN,
    VECTORS,
    VELOCITY,
)
from edmd.tolerances import MORE_ROOM, REBUILD_BEYOND, SAFE, SURELY_NEAR

DONE, LIST_FULL, CELL_TOO_SMALL = -1, int(Ended.LIST_FULL), int(Ended.CELL_TOO_SMALL)


@kernel
def turned(row, kind, anchor):
    """The angle by which a shape has turned since its anchor: for a body of revolution that of its axis."""
    over, axis = 1.0 / anchor[ANCHOR_SIZE], int(kind[AXIS])
    square = 0.0
    for k in range(3):
        if k == axis or axis == NO_AXIS:
            moved = subtract(load(row, VECTORS + 3 * k), scale(over, load(anchor, ANCHOR_VECTORS + 3 * k)))
            square += dot(moved, moved) / (kind[SEMI_AXES + k] * kind[SEMI_AXES + k])
    chord = sqrt(0.5 * square if axis == NO_AXIS else square)
    return 2 * asin(min(0.5 * chord, 1.0))


@kernel
def displacement(row, kind, anchor, size):
    """How far any support value can have come from its anchor's, eq. (6): path, turning and growth. inf for a body never anchored."""
    path = norm(subtract(load(row, POSITION), load(anchor, ANCHOR_POSITION)))
    if kind[SPREAD] > 0.0:
        path += turned(row, kind, anchor) * kind[SPREAD] * max(size, anchor[ANCHOR_SIZE])
    return path + abs(size - anchor[ANCHOR_SIZE]) * kind[LARGEST]


@kernel
def speed_of_surface(row, kind, size):
    """How fast a support value can change at most, growth apart, by (6)."""
    speed = norm(load(row, VELOCITY))
    return speed + fastest(row, kind) * kind[SPREAD] * size if kind[SPREAD] > 0.0 else speed


@kernel
def set_escape(world, body):
    """The time until which an up-to-date body certainly stays within its margin."""
    row, kind, anchor, clock = world.bodies[body], world.kinds[kind_of(world, body)], world.anchors[body], world.clock
    size = size_now(clock)
    left = SAFE * anchor[ANCHOR_MARGIN] - displacement(row, kind, anchor, size)
    if clock[GROWTH] == 0.0:
        speed, longest = speed_of_surface(row, kind, size), inf
    else:
        longest = clock[HORIZON]
        speed = speed_of_surface(row, kind, size + abs(clock[GROWTH]) * longest) + abs(clock[GROWTH]) * kind[LARGEST]
    anchor[ESCAPE_TIME] = clock[NOW] + min(max(left, 0.0) / speed if speed > 0 else inf, longest)


@kernel
def escape(world, body):
    """The body may have left its margin: extend its time, or make its list anew. -> DONE, LIST_FULL or CELL_TOO_SMALL."""
    row, kind, anchor = world.bodies[body], world.kinds[kind_of(world, body)], world.anchors[body]
    advance(row, kind, world.clock[NOW])
    if displacement(row, kind, anchor, size_now(world.clock)) > REBUILD_BEYOND * anchor[ANCHOR_MARGIN]:
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
    begin = int(world.lists.spans[body, BEGIN])
    for slot in range(int(world.lists.spans[body, COUNT]) - 1, -1, -1):
        if not _still_near(world, body, begin + slot):
            _remove(world, body, slot)
    status = _search(world, body)
    if status != DONE:
        world.anchors[body, ANCHOR_POSITION] = inf        # the list is not complete: the next escape makes it again
    return status


@kernel
def _anchor(world, body):
    """Store the pose, size and margin of a body, which is first wrapped into the cell; move it to its grid cell."""
    row, kind, anchor, grid = world.bodies[body], world.kinds[kind_of(world, body)], world.anchors[body], world.grid
    a, b, c = image_of(load(row, POSITION), grid.inverse)
    if a != 0 or b != 0 or c != 0:
        _wrap(world, body, (a, b, c))
    size = size_now(world.clock)
    store(anchor, ANCHOR_POSITION, load(row, POSITION))
    for k in range(9):
        anchor[ANCHOR_VECTORS + k] = size * row[VECTORS + k]
    anchor[ANCHOR_SIZE] = size
    anchor[ANCHOR_MARGIN] = size * kind[MARGIN_LENGTH]
    anchor[ANCHOR_RADIUS] = size * (kind[LARGEST] + kind[MARGIN_LENGTH])
    world.clock[REACH_SIZE] = max(size, world.clock[REACH_SIZE])
    _place(grid, body, load(row, POSITION))


@kernel
def _wrap(world, body, image):
    """Move a body back by so many cell vectors; its neighbours stand in other images then, and their sides of the gaps with them."""
    row, lists, box = world.bodies[body], world.lists, world.grid.box
    store(row, POSITION, displaced(load(row, POSITION), box, -image[0], -image[1], -image[2]))
    begin = int(lists.spans[body, BEGIN])
    for k in range(3):
        world.image[body, k] += image[k]
    back = displaced((0.0, 0.0, 0.0), box, -image[0], -image[1], -image[2])
    for entry in range(begin, begin + int(lists.spans[body, COUNT])):
        twin = lists.links[entry, TWIN]
        lists.numbers[entry, SIDE] += dot(direction_of(lists, entry), back)
        for k in range(3):
            lists.images[entry, IMAGE + k] -= image[k]
            lists.images[twin, IMAGE + k] += image[k]


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
def _still_near(world, body, entry):
    """Whether the gap between the anchors of two neighbours is below the sum of their margins: their last plane settles the very near."""
    a, b = world.anchors[body], world.anchors[world.lists.links[entry, PARTNER]]
    r = imaged(world, entry, subtract(load(b, ANCHOR_POSITION), load(a, ANCHOR_POSITION)))
    margins = a[ANCHOR_MARGIN] + b[ANCHOR_MARGIN]
    if is_sphere(world, body) and is_sphere(world, int(world.lists.links[entry, PARTNER])):
        within = a[ANCHOR_RADIUS] + b[ANCHOR_RADIUS]
        return dot(r, r) < within * within
    s_a, s_b = load_vectors(a, ANCHOR_VECTORS), load_vectors(b, ANCHOR_VECTORS)
    n = direction_of(world.lists, entry)
    h_a, h_b = support(s_a, n), support(s_b, n)
    if dot(n, r) - h_a - h_b < SURELY_NEAR * margins:
        return True
    n, _, _ = best_plane(s_a, s_b, r, h_a / (h_a + h_b), COARSE)
    return _plane_gap(n, r, s_a, s_b) < margins


@kernel
def _near(world, body, other, r):
    """Whether the gap between two anchors, r apart and within reach, is below the sum of their margins, and the plane that tells.

    Cheap planes come first: those across the line of centres and of two spheres settle the far.
    """
    a, b = world.anchors[body], world.anchors[other]
    n = scale(1.0 / norm(r), r)
    if is_sphere(world, body) and is_sphere(world, other):
        return True, n
    s_a, s_b = load_vectors(a, ANCHOR_VECTORS), load_vectors(b, ANCHOR_VECTORS)
    margins = a[ANCHOR_MARGIN] + b[ANCHOR_MARGIN]
    if _plane_gap(n, r, s_a, s_b) >= margins:
        return False, n
    start = a[ANCHOR_MARGIN] / margins
    n = normal(shape_matrix(s_a), shape_matrix(s_b), r, start)
    if _plane_gap(n, r, s_a, s_b) >= margins:
        return False, n
    n, _, _ = best_plane(s_a, s_b, r, start, COARSE)
    return _plane_gap(n, r, s_a, s_b) < margins, n


@kernel
def _plane_gap(n, r, s_a, s_b):
    return dot(n, r) - support(s_a, n) - support(s_b, n)


@kernel
def _mark_listed(world, body):
    """Let every neighbour on the list be known as seen by this rebuild."""
    lists, begin = world.lists, int(world.lists.spans[body, BEGIN])
    for entry in range(begin, begin + int(lists.spans[body, COUNT])):
        lists.seen[lists.links[entry, PARTNER]] = world.tally[REBUILDS]


@kernel
def _listed(world, body, other, shift, one_image):
    """Whether this image of another body is on the list; one_image: no other can be near."""
    lists, begin = world.lists, int(world.lists.spans[body, BEGIN])
    if lists.seen[other] != world.tally[REBUILDS]:
        return False
    if one_image:
        return True
    for entry in range(begin, begin + int(lists.spans[body, COUNT])):
        if lists.links[entry, PARTNER] == other:
            image = lists.images[entry]
            if image[IMAGE] == shift[0] and image[IMAGE + 1] == shift[1] and image[IMAGE + 2] == shift[2]:
                return True
    return False


@kernel
def _search(world, body):
    """Look through the grid cells within reach, each image once, for neighbours that are not listed yet."""
    grid, anchor = world.grid, world.anchors[body]
    _mark_listed(world, body)
    reach = anchor[ANCHOR_RADIUS] + world.clock[REACH] * world.clock[REACH_SIZE]
    f = fraction(load(anchor, ANCHOR_POSITION), grid.inverse)
    left = reach * reach / grid.heights[3]
    one_image = min(grid.heights[0], grid.heights[1], grid.heights[2]) > 2 * reach
    for i in _layers(grid, 0, f[0], left):
        ci, shift_i = _wrapped(i, grid.shape[0])
        left_i = left - _beside(grid, 0, f[0], i)
        for j in _layers(grid, 1, f[1], left_i):
            cj, shift_j = _wrapped(j, grid.shape[1])
            for k in _layers(grid, 2, f[2], left_i - _beside(grid, 1, f[1], j)):
                ck, shift_k = _wrapped(k, grid.shape[2])
                cell = (ci * grid.shape[1] + cj) * grid.shape[2] + ck
                status = _search_cell(world, body, cell, (shift_i, shift_j, shift_k), one_image)
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
def _search_cell(world, body, cell, shift, one_image):
    anchors = world.anchors
    image = displaced((0.0, 0.0, 0.0), world.grid.box, shift[0], shift[1], shift[2])
    here = subtract(load(anchors[body], ANCHOR_POSITION), image)
    other = int(world.grid.first[cell])
    while other >= 0:
        r = subtract(load(anchors[other], ANCHOR_POSITION), here)
        within = anchors[body, ANCHOR_RADIUS] + anchors[other, ANCHOR_RADIUS]
        if dot(r, r) < within * within:
            itself = other == body and shift[0] == 0 and shift[1] == 0 and shift[2] == 0
            if not itself and not _listed(world, body, other, shift, one_image):
                near, n = _near(world, body, other, r)
                if near:
                    if other == body:
                        return CELL_TOO_SMALL
                    if not (_has_room(world, body) and _has_room(world, other)):
                        return LIST_FULL
                    _add(world, body, other, shift, n)
        other = int(world.grid.following[other])
    return DONE


@kernel
def _has_room(world, body):
    """Whether the list can take one more; a full one is moved to the end of the entries, with more room, if there is some."""
    lists, tally = world.lists, world.tally
    span = lists.spans[body]
    if span[COUNT] < span[ROOM]:
        return True
    begin, room = int(tally[ENTRIES]), int(span[ROOM]) + max(MORE_ROOM, int(span[ROOM]) // 4)
    if begin + room > len(lists.numbers):
        return False
    for slot in range(int(span[COUNT])):
        _move(lists, int(span[BEGIN]) + slot, begin + slot)
    span[BEGIN], span[ROOM] = begin, room
    tally[ENTRIES] += room
    return True


@kernel
def _move(lists, source, target):
    """Put an entry into another row: its twin follows."""
    for k in range(ENTRY_ROW):
        lists.numbers[target, k] = lists.numbers[source, k]
    lists.links[lists.links[target, TWIN], TWIN] = target


@kernel
def _add(world, body, other, shift, n):
    """A new pair, in both lists, with its first prediction."""
    lists = world.lists
    entry, twin = _next(lists, body), _next(lists, other)
    lists.links[entry, PARTNER], lists.links[entry, TWIN] = other, twin
    lists.links[twin, PARTNER], lists.links[twin, TWIN] = body, entry
    lists.links[entry, IMAGE // 4] = lists.links[twin, IMAGE // 4] = 0
    for k in range(3):
        lists.images[entry, IMAGE + k] = shift[k]
        lists.images[twin, IMAGE + k] = -shift[k]
    if is_sphere(world, body) and is_sphere(world, other):
        span, _, _, _ = meeting_of_balls(world, entry, ball_now(world, body), ball_now(world, other))
    else:
        span = hold(world, entry, flight_now(world, body), flight_now(world, other), n)
    hold_until(world, entry, world.clock[NOW] + span)


@kernel
def _next(lists, body):
    span = lists.spans[body]
    span[COUNT] += 1
    return int(span[BEGIN]) + int(span[COUNT]) - 1


@kernel
def _remove(world, body, slot):
    lists = world.lists
    entry = int(lists.spans[body, BEGIN]) + slot
    partner, twin = int(lists.links[entry, PARTNER]), int(lists.links[entry, TWIN])
    _vacate(lists, body, entry)
    _vacate(lists, partner, twin)


@kernel
def _vacate(lists, body, entry):
    """Take an entry out of a list: the last one moves there."""
    span = lists.spans[body]
    span[COUNT] -= 1
    last = int(span[BEGIN]) + int(span[COUNT])
    if entry != last:
        _move(lists, last, entry)
