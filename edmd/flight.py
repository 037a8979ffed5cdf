"""Bring a body up to date: straight flight, and rotation of its shape at a constant rate."""

from ccd.compiling import kernel
from ccd.rotation import body_axes, turn
from ccd.separation import semi_axis_vectors
from ccd.vectors import add_scaled, load, store
from edmd.state import ORIENTATION, POSITION, SEMI_AXES, TIME, TURNING, VECTORS, VELOCITY


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
def load_quaternion(row, start):
    return row[start], row[start + 1], row[start + 2], row[start + 3]


@kernel
def position_at(row, now):
    return add_scaled(load(row, POSITION), now - row[TIME], load(row, VELOCITY))


@kernel
def advance(row, now):
    """Move the body of this row to the present."""
    time = now - row[TIME]
    if time == 0.0:
        return
    store(row, POSITION, position_at(row, now))
    w, x, y, z = turn(load_quaternion(row, ORIENTATION), load(row, TURNING), time)
    row[ORIENTATION] = w
    store(row, ORIENTATION + 1, (x, y, z))
    row[TIME] = now
    _set_vectors(row)


@kernel
def _set_vectors(row):
    store_vectors(row, VECTORS, semi_axis_vectors(load(row, SEMI_AXES), body_axes(load_quaternion(row, ORIENTATION))))


@kernel
def advance_all(rows, now):
    for body in range(len(rows)):
        advance(rows[body], now)


@kernel
def set_vectors(rows):
    """The semi-axis vectors of all bodies from their orientations."""
    for body in range(len(rows)):
        _set_vectors(rows[body])
