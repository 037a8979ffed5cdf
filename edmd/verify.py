"""Every invariant of a World, checked on other paths than the engine's: pairs from a tree over all images, contacts from `ccd`.

Cost grows as the number of close pairs times 30 microseconds: for tests and for files, not for every block of a long run.
"""

import numpy as np
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from ccd import Ellipsoid, Status, batch, separation
from ccd.culling import close_pairs
from edmd import state
from edmd.calendar import WAYS, whose
from edmd.epoch import kinetic_energy
from edmd.flight import advance_all
from edmd.inertia import angular_velocities

DEPTH = 1e-11           # relative depth up to which a touching pair may read as overlapping
ENERGY_ERROR = 1e-10    # relative
EARLY = 1e-13           # by how much a contact may come before its prediction: the time in which a body moves by this part of its length
HALVINGS = 60           # of the time from a contact to the later prediction: looks at whether the bodies overlap, down to the contact
PLANE_LOSS = 0.1        # relative amount by which the list's best plane may fall short of the distance it bounds


def verify_world(world, system):
    """AssertionError when bodies overlap, a list misses a neighbour, the calendar is out of order, a prediction is no lower bound, or the
    energy is not the one accounted for. system: the synchronised copy of the world."""
    check_overlaps(system)
    _check_links(world)
    _check_calendar(world)
    _check_margins(world)
    _check_lists(world, system)
    _check_predictions(world)
    counted, is_now, error = world.clock[state.ENERGY], kinetic_energy(world), world.clock[state.ENERGY_ERROR]
    assert abs(counted - is_now) <= ENERGY_ERROR * max(world.clock[state.ENERGY_BEGAN], is_now), (
        f"energy {is_now!r}, but the collisions account for {counted!r}")
    assert abs(error) <= ENERGY_ERROR, f"the energy has come off what the collisions account for by {error!r} of itself"


def check_overlaps(system):
    """No two bodies overlap, by their contact functions."""
    first, second, f = system.contact_functions()
    if len(f):
        worst = f.argmin()
        assert f[worst] >= 1 - 2 * DEPTH, f"bodies {first[worst]} and {second[worst]} overlap: contact function {f[worst]!r}"


def _entries_in_use(world):
    """Entry and body for every neighbour of every list."""
    spans = world.lists.spans
    count = spans[:, state.COUNT]
    body = np.repeat(np.arange(len(spans)), count)
    slot = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return spans[body, state.BEGIN] + slot, body


def _check_links(world):
    entry, body = _entries_in_use(world)
    lists, spans = world.lists, world.lists.spans
    assert (spans[:-1, state.COUNT] <= np.diff(spans[:, state.BEGIN])).all(), "a list is longer than its room"
    assert spans[0, state.BEGIN] == 0, "the first list leaves room to nobody"
    assert spans[-1, state.COUNT] == 0, "there is something in the empty list behind the others"
    assert spans[-1, state.BEGIN] <= len(lists.numbers), "lists reach beyond their room"
    owner = np.full(len(lists.numbers), -1)
    owner[entry] = body
    twin, partner = lists.links[entry, state.TWIN], lists.links[entry, state.PARTNER]
    assert (owner[twin] == partner).all(), "a list entry and its twin do not point at each other"
    assert (lists.links[twin, state.TWIN] == entry).all(), "a list entry and its twin do not point at each other"
    assert (_images(world, twin) == -_images(world, entry)).all(), "the two bodies of a pair see different images"
    held = np.isfinite(lists.numbers[:, state.EVENT])
    assert not (held[entry] & held[twin]).any(), "both bodies hold the prediction of a pair"
    turns = world.kinds[world.bodies[:, state.KIND].astype(int), state.SPREAD] > 0
    entry, twin = (side[turns[body] | turns[partner]] for side in (entry, twin))        # two spheres have no use for a plane
    assert (lists.directions[twin, :3] == -lists.directions[entry, :3]).all(), "the two bodies of a pair see different planes"


def _images(world, entry):
    return world.lists.images[entry, state.IMAGE:state.IMAGE + 3].astype(int)


def _check_calendar(world):
    calendar, n = world.calendar, len(world.bodies)
    for first, end, above in zip(calendar.rounds, [len(calendar.time), *calendar.rounds], calendar.rounds[1:]):
        for match, begin in enumerate(range(first, end, WAYS)):
            winner = min((calendar.time[place], whose(calendar, place)) for place in range(begin, begin + WAYS))
            place = above + match
            assert (calendar.time[place], calendar.body[place]) == winner, f"place {place} of the calendar is not the earliest of its match"
    entry = calendar.time[calendar.rounds[0]:calendar.rounds[0] + n]
    entries, body = _entries_in_use(world)
    earliest = np.full(n, np.inf)
    np.minimum.at(earliest, body, world.lists.numbers[entries, state.EVENT])
    assert (entry <= np.minimum(earliest, world.lists.escapes[:n, state.ESCAPE_TIME])).all(), "a body waits past its earliest event"
    assert (entry >= world.clock[state.NOW] - 1e-12 * abs(world.clock[state.NOW])).all(), "an event lies in the past"


def _check_margins(world):
    """Every body is within its margin: support values against the anchor's in many directions."""
    rng = np.random.default_rng(0)
    n = rng.normal(size=(64, 3))
    n /= np.sqrt((n**2).sum(axis=1, keepdims=True))
    clock = world.clock
    size = clock[state.SIZE] + clock[state.GROWTH] * clock[state.NOW]
    for row, anchor in zip(world.bodies, world.anchors):
        if not np.isfinite(anchor[state.ANCHOR_POSITION]):
            continue
        come = row[state.POSITION:state.POSITION + 3] - anchor[state.ANCHOR_POSITION:state.ANCHOR_POSITION + 3]
        now = size * np.linalg.norm(row[state.VECTORS:state.VECTORS + 9].reshape(3, 3) @ n.T, axis=0)
        then = np.linalg.norm(anchor[state.ANCHOR_VECTORS:state.ANCHOR_VECTORS + 9].reshape(3, 3) @ n.T, axis=0)
        assert (n @ come + now - then <= anchor[state.ANCHOR_MARGIN]).all(), "a body has left its margin before its escape"


def _anchored(world, body, offset):
    vectors = world.anchors[body, state.ANCHOR_VECTORS:state.ANCHOR_VECTORS + 9].reshape(3, 3)
    lengths = np.linalg.norm(vectors, axis=1)
    return Ellipsoid(lengths, offset, Rotation.from_matrix((vectors / lengths[:, None]).T).as_quat(scalar_first=True))


def _check_lists(world, system):
    """Every pair of images whose anchors are nearer than their margins is listed."""
    position = world.anchors[:, state.ANCHOR_POSITION:state.ANCHOR_POSITION + 3]
    first, second, offset = close_pairs(position, world.anchors[:, state.ANCHOR_RADIUS], system.box)
    entry, a = _entries_in_use(world)
    b = world.lists.links[entry, state.PARTNER]
    vector = position[b] + _images(world, entry) @ system.box - position[a]
    inverse = np.linalg.inv(system.box)

    def keys(i, j, vectors):
        images = np.rint((vectors - position[j] + position[i]) @ inverse).astype(int)
        return [tuple(key) for key in np.column_stack([i, j, images]).tolist()]
    listed = set(keys(a, b, vector))
    margin = world.anchors[:, state.ANCHOR_MARGIN]
    for key, i, j, v in zip(keys(first, second, offset), first, second, offset):
        if key not in listed:
            gap = _distance(_anchored(world, i, np.zeros(3)), _anchored(world, j, v), (1 - PLANE_LOSS) * (margin[i] + margin[j]))
            assert gap >= (1 - PLANE_LOSS) * (margin[i] + margin[j]), f"bodies {i} and {j} are neighbours, {gap!r} apart, and not listed"


def _distance(a, b, enough):
    """A lower bound of the distance of two bodies: the gap of the pencil's plane when that is enough, else that of the best plane."""
    found = separation(a, b)
    if found.gap >= enough or not np.isfinite(found.gap):
        return found.gap

    def overlap_of_slabs(n):
        n = n / np.sqrt(n @ n)
        return np.sqrt(n @ a.shape_matrix @ n) + np.sqrt(n @ b.shape_matrix @ n) - n @ (b.center - a.center)
    return -minimize(overlap_of_slabs, found.normal).fun


def _check_predictions(world):
    """No pair touches before the time that is on record for it."""
    clock = world.clock
    now, size = clock[state.NOW], clock[state.SIZE] + clock[state.GROWTH] * clock[state.NOW]
    entry, body = _entries_in_use(world)
    times = world.lists.numbers[entry, state.EVENT]
    held = np.isfinite(times)
    if not held.any():
        return
    entry, span = entry[held], times[held] - now
    rows = world.bodies.copy()
    advance_all(rows, world.turns.copy(), world.kinds, now)
    kinds = world.kinds[rows[:, state.KIND].astype(int)]
    momenta, free = rows[:, state.MOMENTUM:state.MOMENTUM + 3], kinds[:, state.MOTION] == state.FREE
    moments = np.where(free[:, None], 1 / kinds[:, state.INVERSE_MOMENTS:state.INVERSE_MOMENTS + 3], 1.0)      # equal ones turn steadily
    spin = np.where(free[:, None], angular_velocities(rows[:, state.ORIENTATION:state.ORIENTATION + 4], momenta, moments),
                    kinds[:, state.ACROSS, None] * momenta)

    def bodies(index, shift):
        part, kind = rows[index], kinds[index]
        return batch.Bodies(kind[:, state.SEMI_AXES:state.SEMI_AXES + 3] * size, part[:, state.POSITION:state.POSITION + 3] + shift,
                            part[:, state.ORIENTATION:state.ORIENTATION + 4], part[:, state.VELOCITY:state.VELOCITY + 3],
                            spin[index], clock[state.GROWTH] / size, moments[index] if free.any() else None)
    free_time = clock[state.REFINE]
    shrunk = 0.5 * size / -clock[state.GROWTH] if clock[state.GROWTH] < 0 else np.inf
    longest = max(min(span.max(), 100 * free_time, shrunk), 1e-300)
    a = bodies(body[held], 0.0)
    b = bodies(world.lists.links[entry, state.PARTNER], _images(world, entry) @ world.grid.box)
    time, status = batch.first_contact(a, b, longest)
    speed = np.sqrt((rows[:, state.VELOCITY:state.VELOCITY + 3]**2).sum(axis=1).mean())
    slack = EARLY * size * kinds[:, state.LARGEST].max() / speed if speed > 0 else 0.0
    for k in np.flatnonzero((status == Status.CONTACT) & (time < np.minimum(span, longest) - slack)):
        pair, shift = [body[held][k], world.lists.links[entry[k], state.PARTNER]], _images(world, entry[k:k + 1])[0] @ world.grid.box
        later = now + time[k] + (min(span[k], longest) - time[k]) * 0.5**np.arange(HALVINGS)
        assert all(_apart_at(world, pair, shift, t) for t in later), f"a pair touches at {time[k]!r}, before its prediction {span[k]!r}"


def _apart_at(world, bodies, shift, time):
    """Whether two bodies, the second moved by a vector, do not overlap at a time, but for rounding."""
    rows, size = world.bodies[bodies].copy(), world.clock[state.SIZE] + world.clock[state.GROWTH] * time
    advance_all(rows, world.turns[bodies], world.kinds, time)
    one, other = (Ellipsoid(size * world.kinds[int(row[state.KIND]), state.SEMI_AXES:state.SEMI_AXES + 3],
                            row[state.POSITION:state.POSITION + 3] + move, row[state.ORIENTATION:state.ORIENTATION + 4])
                  for row, move in zip(rows, (0.0, shift)))
    return separation(one, other).contact_function >= 1 - 2 * DEPTH
