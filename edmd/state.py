"""World: the whole state of a run as named tuples of arrays, and the layout of their rows. What the kernels read and write.

A body's position, orientation and semi-axis vectors are those at its own TIME: bodies are brought up to date one at a time. Semi-axes are
those at size 1; the common size of all bodies is clock[SIZE] + clock[GROWTH] * (now), so that growth touches no body.
"""

from typing import NamedTuple

import numpy as np

# bodies: one row of 32 numbers (four cache lines) a body
POSITION, VELOCITY, TURNING, VECTORS = 0, 3, 6, 9        # TURNING: angular velocity at which the shape turns; VECTORS: semi-axis vectors
TIME, BEND = 18, 19                                      # BEND: bound on the curvature of the support function in time, eq. (7)
ORIENTATION, SEMI_AXES = 20, 24
INVERSE_MASS, INVERSE_INERTIA, SPREAD, LARGEST, MARGIN_LENGTH = 27, 28, 29, 30, 31
BODY_ROW = 32

# anchors: where a body was, at which size, when its list was made
# (the first cache line, of eight numbers, is all that the search for neighbours needs of a body that is too far)
ANCHOR_POSITION, ANCHOR_RADIUS, ANCHOR_MARGIN, ANCHOR_SIZE, ESCAPE_TIME = 0, 3, 4, 5, 6
ANCHOR_VECTORS, ANCHOR_ORIENTATION = 8, 17
ANCHOR_ROW = 24

# pairs: one cache line a pair, which both arrays name. link: the two bodies, their slots in each other's lists, the periodic image of the
# second, as integers in the first half of the line; plane: normal and lambda in the other half.
BODY_A, BODY_B, SLOT_A, SLOT_B, SHIFT = 0, 1, 2, 3, 4
NORMAL, PENCIL = 4, 7
PAIR_ROW = 8

# clock: NOW and every time in the world count from EPOCH. REACH: longest semi-axis plus margin of all bodies at size 1; REACH_SIZE: the
# largest size of an anchor. REFINE: a time, see tolerances. ENERGY: of the motions that collisions exchange; ENERGY_TIME: its time integral
# up to ENERGY_SINCE; it and VIRIAL are sums of this epoch, which began after EPOCH_BEGAN collisions. ENERGY_ERROR: sum over the epochs of
# the amounts by which ENERGY, as the collisions account for it, had come off what it is, in units of what it was when it was last counted,
# ENERGY_BEGAN. INSTANT: a span that is no progress. DRIFT: common velocity of all bodies, three numbers.
(NOW, EPOCH, SIZE, GROWTH, REFINE, HORIZON, VIRIAL, ENERGY, ENERGY_TIME, ENERGY_SINCE, REACH, REACH_SIZE, ENERGY_ERROR, ENERGY_BEGAN,
 INSTANT, DRIFT) = range(16)
CLOCK_ROW = 24

# tally
# SPARED: collisions that the TC model made elastic (EPOCH_SPARED: before this epoch). FAINT: weight of the last collisions in a row that
# were too faint to be told from rounding, the last of them of the row FAINT_PAIR of pairs
COLLISIONS, NEXT_EPOCH, EPOCH_BEGAN, EVENTS, LOOKS, REBUILDS, FREE_PAIRS, STANDING, SPARED, EPOCH_SPARED, FAINT, FAINT_PAIR = range(12)
TALLY_ROW = 16


class Lists(NamedTuple):
    """Neighbour lists. A pair's earliest possible contact stands in the list of the body that predicted it last, inf in the other."""

    count: np.ndarray       # int32 (n,)
    partner: np.ndarray     # int32 (n, room)
    pair: np.ndarray        # int32 (n, room)
    time: np.ndarray        # float64 (n, room)


class Pairs(NamedTuple):
    plane: np.ndarray       # float64 (pairs, PAIR_ROW)
    link: np.ndarray        # int32 (pairs, 2 PAIR_ROW), a view of plane
    free: np.ndarray        # int32 (pairs,): stack of unused rows


class Grid(NamedTuple):
    """Cells that hold the bodies by their anchors, and the periodic box."""

    shape: np.ndarray       # int64 (3,)
    first: np.ndarray       # int32 (cells,)
    following: np.ndarray   # int32 (n,)
    cell: np.ndarray        # int32 (n,), -1: not placed
    box: np.ndarray         # float64 (3, 3), rows are the cell vectors
    inverse: np.ndarray     # float64 (3, 3)
    heights: np.ndarray     # float64 (4,), distances of opposite faces; the smallest |x|^2 / (squared distances from three faces of x)


class Calendar(NamedTuple):
    """A tournament: leaf k + leaves belongs to body k, every inner node holds the earlier of its two children."""

    time: np.ndarray        # float64 (2 leaves,)
    body: np.ndarray        # int32 (2 leaves,)
    slot: np.ndarray        # int32 (n,): what the body waits for


class Contacts(NamedTuple):
    """What the rule of the collisions needs; all but its row only where it says so."""

    rule: np.ndarray                # float64 (RULE_ROW,), see edmd/rules/kinds.py
    last: np.ndarray                # float64 (n,): time of a body's last collision, -inf before; kept with a contact time
    inverse_moments: np.ndarray     # float64 (n, 3), principal; of rough bodies
    phase: np.ndarray               # float64 (n,): angle about the axis by which a rough body is ahead of its shape, at the epoch


class World(NamedTuple):
    bodies: np.ndarray      # float64 (n, BODY_ROW)
    image: np.ndarray       # int32 (n, 3)
    anchors: np.ndarray     # float64 (n, ANCHOR_ROW)
    lists: Lists
    pairs: Pairs
    grid: Grid
    calendar: Calendar
    clock: np.ndarray       # float64 (CLOCK_ROW,)
    tally: np.ndarray       # int64 (TALLY_ROW,)
    contacts: Contacts
