"""Neighbour lists that follow the shape (docs/theory.md, section 4).

Each body has an anchor: the pose it was about to have when its list was made, with a margin. It stays inside the anchor shape grown by the
margin until its ESCAPE_TIME. Two bodies are neighbours when the gap between their anchors is below the sum of their margins: so nothing
outside the list can be touched before the escape. One body at a time is looked at again; the predictions of the pairs that stay are kept.
"""

from math import inf, pi

from ccd.compiling import kernel, large_kernel
from ccd.lanes import absolute, first, greater, least, lesser, most, second, sqrt, two, where_less
from ccd.vectors import add_scaled, dot, load, norm, store, subtract
from edmd.boundary import displaced, fraction, image_of
from edmd.cells import extent_along, place, row_within, scan, unpacked, window
from edmd.couple import flights_of
from edmd.events import Ended
from edmd.flight import (
    advance,
    both,
    course,
    each,
    kind_of,
    load_vectors,
    store_vectors,
    vectors_after,
    vectors_of_both,
)
from edmd.nearness import near, still_near
from edmd.pairs import (
    ball_now,
    direction_of,
    hold_until,
    is_sphere,
    meeting_of_balls,
    record,
    rounded,
    size_now,
)
from edmd.prefetch import fetch_anchor
from edmd.sieve import hull
from edmd.state import (
    ANCHOR_MARGIN,
    ANCHOR_POSITION,
    ANCHOR_RADIUS,
    ANCHOR_SIZE,
    ANCHOR_VECTORS,
    BEGIN,
    COUNT,
    ENTRY_ROW,
    ESCAPE_TIME,
    FASTEST,
    GROWTH,
    HITS,
    HORIZON,
    IMAGE,
    LARGEST,
    MARGIN_LENGTH,
    NOW,
    PARTNER,
    POSITION,
    REACH_SIZE,
    REBUILDS,
    REFINE,
    SEEN,
    SIDE,
    SLOT,
    SPREAD,
    STRAYING,
    TWIN,
    VECTORS,
    VELOCITY,
)
from edmd.tolerances import FULL_IN_A_ROW, LEAD, LEAD_SHARE, REBUILD_BEYOND, SAFE

DONE, NO_ROOM, CELL_TOO_SMALL = -1, int(Ended.NO_ROOM), int(Ended.CELL_TOO_SMALL)


@kernel
def turned(vectors, anchored, weights, over):
    """A bound on the angle by which a shape has turned since its anchor, of a body of revolution its axis; 2 % above it at 0.4 rad.

    vectors: semi-axis vectors; anchored: of the anchor, whose size is 1 / over; weights: STRAYING.
    """
    p, q, r = (add_scaled(vectors[0], -over, anchored[0]), add_scaled(vectors[1], -over, anchored[1]),
               add_scaled(vectors[2], -over, anchored[2]))
    half = lesser(0.5 * sqrt(weights[0] * dot(p, p) + weights[1] * dot(q, q) + weights[2] * dot(r, r)), 1.0)
    return 2 * half * (1 + (pi / 2 - 1) * half * half)            # asin(x) <= x + (pi / 2 - 1) x^3


@kernel
def strayed(angle, sizes, spread, largest):
    """How far any support value can have come from its anchor's by turning, and by growth, eq. (6). sizes: now, and of the anchor."""
    return absolute(sizes[0] - sizes[1]) * largest + angle * spread * greater(sizes[0], sizes[1])


@kernel
def straying(fastest, spread, largest, clock):
    """How fast a support value can change at most within the horizon of growth: by turning, eq. (6), and by growth."""
    growth = abs(clock[GROWTH])
    return (size_now(clock) + (growth * clock[HORIZON] if growth > 0.0 else 0.0)) * fastest * spread, growth * largest


@kernel
def set_escapes(world, body, partner):
    """The times until which two up-to-date bodies, which may be one, certainly stay within their margins."""
    a, b, anchor_a, anchor_b = world.bodies[body], world.bodies[partner], world.anchors[body], world.anchors[partner]
    kind_a, kind_b, size = world.kinds[kind_of(world, body)], world.kinds[kind_of(world, partner)], size_now(world.clock)
    spread, largest, anchored = each(kind_a, kind_b, SPREAD), each(kind_a, kind_b, LARGEST), each(anchor_a, anchor_b, ANCHOR_SIZE)
    turning, growth = straying(each(world.turns[body], world.turns[partner], FASTEST), spread, largest, world.clock)
    angle = two(0.0, 0.0)
    if most(spread) > 0.0:
        vectors, there = vectors_of_both(a, b, VECTORS), vectors_of_both(anchor_a, anchor_b, ANCHOR_VECTORS)
        angle = turned(vectors, there, both(kind_a, kind_b, STRAYING), 1.0 / anchored)
    path = subtract(both(a, b, POSITION), both(anchor_a, anchor_b, ANCHOR_POSITION))
    room = SAFE * each(anchor_a, anchor_b, ANCHOR_MARGIN) - strayed(angle, (size, anchored), spread, largest)
    span = staying(path, both(a, b, VELOCITY), room, turning + growth)
    _escape_after(world, body, first(span))
    _escape_after(world, partner, second(span))


@kernel
def _escape_after(world, body, span):
    clock = world.clock
    world.lists.escapes[body, ESCAPE_TIME] = clock[NOW] + (span if clock[GROWTH] == 0.0 else min(span, clock[HORIZON]))


@kernel
def staying(r, v, room, shrinking):
    """How long |r + v t| stays below a room that shrinks at this rate, eq. (6c)."""
    left = room * room - dot(r, r)
    half, bend = dot(r, v) + room * shrinking, dot(v, v) - shrinking * shrinking
    root = sqrt(greater(half * half + bend * left, 0.0))
    over, under = where_less(half, 0.0, root - half, left), where_less(half, 0.0, bend, half + root)
    span = over / where_less(0.0, under, under, 1.0)
    if not least(under) > 0.0:                              # nothing moves, or rounding hides it
        speed = norm(v) + shrinking
        slow = where_less(0.0, speed, (room - norm(r)) / where_less(0.0, speed, speed, 1.0), inf)
        span = where_less(0.0, under, span, slow)
    return where_less(0.0, lesser(room, left), span, 0.0)


@kernel
def escape(world, body):
    """The body may have left its margin: extend its time, or make its list anew. -> DONE, NO_ROOM or CELL_TOO_SMALL."""
    row, kind, anchor, size = world.bodies[body], world.kinds[kind_of(world, body)], world.anchors[body], size_now(world.clock)
    advance(row, world.turns[body], kind, world.clock[NOW])
    angle, path = 0.0, subtract(load(row, POSITION), load(anchor, ANCHOR_POSITION))        # inf for one never anchored
    if kind[SPREAD] > 0.0:
        angle = turned(load_vectors(row, VECTORS), load_vectors(anchor, ANCHOR_VECTORS), load(kind, STRAYING), 1.0 / anchor[ANCHOR_SIZE])
    if norm(path) + strayed(angle, (size, anchor[ANCHOR_SIZE]), kind[SPREAD], kind[LARGEST]) > REBUILD_BEYOND * anchor[ANCHOR_MARGIN]:
        return rebuild(world, body)
    set_escapes(world, body, body)
    return DONE


@kernel
def rebuild(world, body):
    """Anchor the body where it will be and make its list: drop the pairs that have come apart, find the new ones."""
    world.tally[REBUILDS] += 1
    anchor, status = world.anchors[body], NO_ROOM
    if _anchor(world, body):
        begin = int(world.lists.spans[body, BEGIN])
        _mark_listed(world, body)
        for slot in range(int(world.lists.spans[body, COUNT]) - 1, -1, -1):
            if not still_near(world, body, begin + slot):
                _remove(world, body, slot)
        status = _search(world, body)
    if status != DONE:                                      # the list is not complete: it is to be made again, now
        anchor[ANCHOR_POSITION], world.lists.escapes[body, ESCAPE_TIME] = inf, world.clock[NOW]
    return status


@kernel
def _anchor(world, body):
    """Store the size of a body, its margin, its pose a little ahead, and how long it stays near that: it will be there, if nobody is in its
    way. The body is first wrapped so that its anchor is in the cell; it moves to the grid cell of its anchor, if that has room."""
    row, kind, anchor, grid, clock = world.bodies[body], world.kinds[kind_of(world, body)], world.anchors[body], world.grid, world.clock
    size, velocity = size_now(clock), load(row, VELOCITY)
    margin, (turning, growth) = size * kind[MARGIN_LENGTH], straying(world.turns[body, FASTEST], kind[SPREAD], kind[LARGEST], clock)
    speed = norm(velocity) + turning + growth
    lead = min(LEAD * clock[REFINE], LEAD_SHARE * margin / speed) if speed > 0.0 else 0.0
    a, b, c = image_of(add_scaled(load(row, POSITION), lead, velocity), grid.inverse)
    if a != 0 or b != 0 or c != 0:
        _wrap(world.lists, world.image, grid.box, row, body, (a, b, c))
    store(anchor, ANCHOR_POSITION, add_scaled(load(row, POSITION), lead, velocity))
    store_vectors(anchor, ANCHOR_VECTORS, vectors_after(row, world.turns[body], kind, lead, size))
    anchor[ANCHOR_SIZE], anchor[ANCHOR_MARGIN], anchor[ANCHOR_RADIUS] = size, margin, size * kind[LARGEST] + margin
    _escape_after(world, body, lead + (SAFE * margin - growth * lead) / speed if speed > 0.0 else inf)
    clock[REACH_SIZE] = max(size, clock[REACH_SIZE])
    return place(world.cells, grid, body, kind, anchor)


@large_kernel
def _wrap(lists, images, box, row, body, image):
    """Move a body back by so many cell vectors; its neighbours stand in other images then, and their sides of the gaps with them."""
    store(row, POSITION, displaced(load(row, POSITION), box, -image[0], -image[1], -image[2]))
    begin = int(lists.spans[body, BEGIN])
    for k in range(3):
        images[body, k] += image[k]
    back = displaced((0.0, 0.0, 0.0), box, -image[0], -image[1], -image[2])
    for entry in range(begin, begin + int(lists.spans[body, COUNT])):
        twin = lists.links[entry, TWIN]
        lists.numbers[entry, SIDE] += dot(direction_of(lists, entry), back)
        for k in range(3):
            lists.images[entry, IMAGE + k] -= image[k]
            lists.images[twin, IMAGE + k] += image[k]


@kernel
def _mark_listed(world, body):
    """Let every neighbour on the list be known as seen by this rebuild: if it stays it need not be found, nor looked into again if not."""
    lists, begin = world.lists, int(world.lists.spans[body, BEGIN])
    for entry in range(begin, begin + int(lists.spans[body, COUNT])):
        partner = int(lists.links[entry, PARTNER])
        fetch_anchor(world.anchors, partner)
        world.anchors[partner, SEEN] = world.tally[REBUILDS]


@kernel
def _listed(world, body, other, shift, one_image):
    """Whether this image of another body is on the list; one_image: no other can be near."""
    lists, begin = world.lists, int(world.lists.spans[body, BEGIN])
    if world.anchors[other, SEEN] != world.tally[REBUILDS]:
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
    """Find the neighbours that are not listed yet, among the bodies of every level of size."""
    cells, grid, anchor, kind = world.cells, world.grid, world.anchors[body], world.kinds[kind_of(world, body)]
    position, radius, margin = load(anchor, ANCHOR_POSITION), anchor[ANCHOR_RADIUS], anchor[ANCHOR_MARGIN]
    extent = extent_along(grid, load_vectors(anchor, ANCHOR_VECTORS))
    f = fraction(position, grid.inverse)
    widest = min(grid.heights[0], grid.heights[1], grid.heights[2])
    for level in range(len(cells.levels)):
        layers, unit, found = cells.levels[level], cells.reaches[level, 0], 0
        outer, own = unit * world.clock[REACH_SIZE], hull(anchor, kind, 1.0 / unit)
        reach, beside = radius + outer, margin + outer
        lengths = cells.reaches[level, 1] + 2 * reach / unit
        first, last = window(grid, layers, f, (extent[0] + beside, extent[1] + beside, extent[2] + beside))
        i, j, k, end = first[0], first[1] - 1, 0, -1                    # before the first row
        while i <= last[0]:
            if k <= end:
                found = scan(cells, grid, level, (i, j, k), position, own, lengths, found)
                k += 1
            else:
                i, j = (i, j + 1) if j < last[1] else (i + 1, first[1])
                k, end = row_within(grid, layers, f, (i, j), reach, (first[2], last[2]))
            if found > HITS or i > last[0]:
                status = _sift(world, body, found, widest > 2 * (reach + margin))     # a pair just dropped was within reach two margins ago
                if status != DONE:
                    return status
                found = 0
    return DONE


@kernel
def _sift(world, body, found, one_image):
    """List those of the bodies found that are neighbours and not listed yet."""
    anchors, hits, ball, new = world.anchors, world.cells.hits, is_sphere(world, body), 0
    for k in range(found):
        other, i, j, m = unpacked(hits[k])
        itself = other == body and i == 0 and j == 0 and m == 0
        if not itself and not _listed(world, body, other, (i, j, m), one_image):
            fetch_anchor(anchors, other)
            hits[new] = hits[k]
            new += 1
    for k in range(new):
        other, i, j, m = unpacked(hits[k])
        r = subtract(load(anchors[other], ANCHOR_POSITION), load(anchors[body], ANCHOR_POSITION))
        if i != 0 or j != 0 or m != 0:
            r = displaced(r, world.grid.box, i, j, m)
        listed, n = near(r, anchors[body], anchors[other], ball and is_sphere(world, other))
        if listed:
            if other == body:
                return CELL_TOO_SMALL
            first, last = min(body, other), max(body, other)           # who takes, takes from those behind
            if not (_has_room(world.lists, first) and _has_room(world.lists, last)):
                return NO_ROOM
            _add(world, body, other, (i, j, m), n)
    return DONE


@large_kernel
def _has_room(lists, body):
    """Whether the list can take one more. A full one takes a place from the next that has one to spare, whose lists between move up by one:
    the first entry of each goes behind its last. The last list takes from what is behind the lists."""
    spans, giver, end = lists.spans, body, len(lists.spans) - 1
    while giver < end and spans[giver, BEGIN] + spans[giver, COUNT] == spans[giver + 1, BEGIN]:
        giver += 1
        if giver > body + FULL_IN_A_ROW:
            return False
    if giver == end and spans[end, BEGIN] == len(lists.numbers):
        return False
    for one in range(giver, body, -1):
        span = spans[one]
        begin, count, slot = int(span[BEGIN]), int(span[COUNT]), int(span[SLOT])
        if count > 0:
            _move(lists, begin, begin + count)
        span[BEGIN], span[SLOT] = begin + 1, slot - 1 if slot > 0 else count - 1 if slot == 0 else slot
    return True


@kernel
def _move(lists, source, target):
    """Put an entry into another row: its twin follows."""
    for k in range(ENTRY_ROW):
        lists.numbers[target, k] = lists.numbers[source, k]
    lists.links[lists.links[target, TWIN], TWIN] = target


@kernel
def copy_entries(old, new, moved):
    """Copy every list to where `new` has it; twins follow. moved: int32 (old entries,), where each goes, to be filled."""
    for body in range(len(old.spans)):
        source, target = int(old.spans[body, BEGIN]), int(new.spans[body, BEGIN])
        for slot in range(int(old.spans[body, COUNT])):
            moved[source + slot] = target + slot
    for body in range(len(old.spans)):
        source, target = int(old.spans[body, BEGIN]), int(new.spans[body, BEGIN])
        for slot in range(int(old.spans[body, COUNT])):
            for k in range(ENTRY_ROW):
                new.numbers[target + slot, k] = old.numbers[source + slot, k]
            new.links[target + slot, TWIN] = moved[old.links[source + slot, TWIN]]


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
        n, pair = rounded(n), flights_of(world, body, other, world.clock[NOW])
        span = record(world, entry, pair, n, course(pair, n))
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
