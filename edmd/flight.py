"""Bring a body up to date: straight flight, and rotation of its shape."""

from ccd.compiling import kernel
from ccd.rotation import body_axes, load_quaternion, turn
from ccd.separation import semi_axis_vectors
from ccd.vectors import add_scaled, load, scale, store
from edmd.state import ACROSS, KIND, MOMENTUM, ORIENTATION, POSITION, SEMI_AXES, SPREAD, TIME, VECTORS, VELOCITY


@kernel
def load_vectors(row, start):
    """Semi-axis vectors: nine numbers of a row as three vectors."""
    return load(row, start), load(row, start + 3), load(row, start + 6)


@kernel
def store_vectors(row, start, vectors):
    store(row, start, vectors[0])
    store(row, start + 3, vectors[1])
    store(row, start + 6, vectors[2])


@kernel
def kind_of(world, body):
    """Row of its kind in the table."""
    return int(world.bodies[body, KIND])


@kernel
def position_at(row, now):
    return add_scaled(load(row, POSITION), now - row[TIME], load(row, VELOCITY))


@kernel
def turning(row, kind):
    """The angular velocity at which the shape turns, eq. (12)."""
    return scale(kind[ACROSS], load(row, MOMENTUM))


@kernel
def advance(row, kind, now):
    """Move the body of this row to the present."""
    time = now - row[TIME]
    if time == 0.0:
        return
    store(row, POSITION, position_at(row, now))
    row[TIME] = now
    if kind[SPREAD] == 0.0:
        return
    w, x, y, z = turn(load_quaternion(row, ORIENTATION), turning(row, kind), time)
    row[ORIENTATION] = w
    store(row, ORIENTATION + 1, (x, y, z))
    _set_vectors(row, kind)


@kernel
def _set_vectors(row, kind):
    store_vectors(row, VECTORS, semi_axis_vectors(load(kind, SEMI_AXES), body_axes(load_quaternion(row, ORIENTATION))))


@kernel
def advance_all(rows, kinds, now):
    for body in range(len(rows)):
        advance(rows[body], kinds[int(rows[body, KIND])], now)


@kernel
def set_vectors(rows, kinds):
    """The semi-axis vectors of all bodies from their orientations."""
    for body in range(len(rows)):
        _set_vectors(rows[body], kinds[int(rows[body, KIND])])
