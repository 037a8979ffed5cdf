"""Arrays of flights in blocks, one array for each number of a pair: a pass of the certified shoot becomes vector instructions.

A block of pairs is copied into columns that fit the first-level cache. Every pass takes all that are underway one step further
(`first_contact.advance`, the same for a pair alone); who has arrived leaves, and the last one takes its place. The pencil is maximised for
one pair at a time: one in five needs it at all.
"""

from math import inf

import numba
import numpy as np

from ccd.compiling import kernel, parallel_kernel
from ccd.first_contact import LAGGING, NO_CONTACT, UNDERWAY, UNRESOLVED, advance, launch, maximised
from ccd.rotation import load_quaternion
from ccd.tolerances import SHOOT_STEPS
from ccd.vectors import load

BLOCK = 64                  # pairs; their columns take 22 kB
WIDTH = 4                   # lanes of a vector instruction: a pass takes a multiple of it
BODY_B, COURSE, STATE, STATUS, COLUMNS = 11, 22, 29, 44, 45


@kernel
def _vector(column, at, k):
    return column[at, k], column[at + 1, k], column[at + 2, k]


@kernel
def _put(column, at, k, vector):
    column[at, k], column[at + 1, k], column[at + 2, k] = vector


@kernel
def _body(column, at, k):
    return _vector(column, at, k), _vector(column, at + 3, k), column[at + 6, k], column[at + 7, k], _vector(column, at + 8, k)


@kernel
def _put_body(column, at, k, body):
    semi_axes, axis, rate, growth, swing = body
    _put(column, at, k, semi_axes)
    _put(column, at + 3, k, axis)
    column[at + 6, k], column[at + 7, k] = rate, growth
    _put(column, at + 8, k, swing)


@kernel
def _course(column, k):
    return _vector(column, COURSE, k), _vector(column, COURSE + 3, k), column[COURSE + 6, k]


@kernel
def _state(column, k):
    turn_a = (column[STATE, k], column[STATE + 1, k], column[STATE + 2, k], column[STATE + 3, k])
    turn_b = (column[STATE + 4, k], column[STATE + 5, k], column[STATE + 6, k], column[STATE + 7, k])
    return (turn_a, turn_b, _vector(column, STATE + 8, k), column[STATE + 11, k], column[STATE + 12, k], column[STATE + 13, k],
            column[STATE + 14, k])


@kernel
def _put_state(column, k, state):
    turn_a, turn_b, n, time, ahead, guess, plane = state
    column[STATE, k], column[STATE + 1, k], column[STATE + 2, k], column[STATE + 3, k] = turn_a
    column[STATE + 4, k], column[STATE + 5, k], column[STATE + 6, k], column[STATE + 7, k] = turn_b
    _put(column, STATE + 8, k, n)
    column[STATE + 11, k], column[STATE + 12, k], column[STATE + 13, k], column[STATE + 14, k] = time, ahead, guess, plane


@kernel
def _flight(flights, k):
    semi_axes, center, orientation, velocity, spin, growth = flights
    return (load(semi_axes[k], 0), load(center[k], 0), load_quaternion(orientation[k], 0), load(velocity[k], 0), load(spin[k], 0),
            growth[k])


@kernel
def _advance(column, size):
    """One pass of the shoot for the pairs in the first `size` columns."""
    for k in range(size):
        column[STATUS, k], state = advance(_body(column, 0, k), _body(column, BODY_B, k), _course(column, k), _state(column, k))
        _put_state(column, k, state)


@parallel_kernel
def first_contacts(flights_a, flights_b, t_max, time, status):
    """First contact of each pair of flights in [0, t_max] into `time` and `status`, both (n,).

    Flights are arrays (semi_axes, center, orientation, velocity, angular_velocity, growth_rate), one row a body.
    """
    n = len(time)
    for block in numba.prange((n + BLOCK - 1) // BLOCK):
        start = block * BLOCK
        column, pair = np.empty((COLUMNS, BLOCK)), np.empty(BLOCK, dtype=np.int64)
        live = 0
        for k in range(start, min(start + BLOCK, n)):
            found, a, b, course, state = launch(_flight(flights_a, k), _flight(flights_b, k), t_max)
            if found == UNDERWAY:
                _put_body(column, 0, live, a)
                _put_body(column, BODY_B, live, b)
                _put(column, COURSE, live, course[0])
                _put(column, COURSE + 3, live, course[1])
                column[COURSE + 6, live] = course[2]
                _put_state(column, live, state)
                pair[live] = k
                live += 1
            else:
                status[k], time[k] = found, inf if found == NO_CONTACT else 0.0
        for k in range(live, min(BLOCK, live + WIDTH)):
            for i in range(COLUMNS):
                column[i, k] = column[i, 0]
        for _ in range(SHOOT_STEPS):
            if live == 0:
                break
            _advance(column, (live + WIDTH - 1) // WIDTH * WIDTH)
            k = 0
            while k < live:
                found = column[STATUS, k]
                if found == LAGGING:
                    converged, state = maximised(_body(column, 0, k), _body(column, BODY_B, k), _course(column, k), _state(column, k))
                    _put_state(column, k, state)
                    found = UNDERWAY if converged else UNRESOLVED
                if found == UNDERWAY:
                    k += 1
                    continue
                status[pair[k]], time[pair[k]] = found, inf if found == NO_CONTACT else column[STATE + 11, k]
                live -= 1
                pair[k] = pair[live]
                for i in range(COLUMNS):
                    column[i, k] = column[i, live]
        for k in range(live):
            status[pair[k]], time[pair[k]] = UNRESOLVED, column[STATE + 11, k]
