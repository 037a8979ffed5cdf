"""World: the whole state of a run as named tuples of arrays, and the layout of their rows. What the kernels read and write.

A body's position, orientation and semi-axis vectors are those at its own TIME: bodies are brought up to date one at a time. Semi-axes are
those at size 1; the common size of all bodies is clock[SIZE] + clock[GROWTH] * (now), so that growth touches no body.
"""

from typing import NamedTuple

import numpy as np

# bodies: three cache lines a body, the first of which is all that a sphere needs. MOMENTUM: angular, constant in flight; VECTORS: semi-axes
POSITION, VELOCITY, TIME, KIND = 0, 3, 6, 7
VECTORS, MOMENTUM, ORIENTATION = 8, 17, 20
BODY_ROW = 24

# turns: bounds of a body's turning, constant in flight (flight.py): its rate, and of support values the bend for all time, and those of
# `ccd.first_contact.support_course` on the third and the fourth derivative of their squares.
# MET: the normal of the contact that it is going to make at MET_TIME with the neighbour that its span names, if that has had no
# collision since: its own time is MET_SINCE still. From THIRD on of free tops only; TOP: of a `ccd.free_top.Top` what `top_from` takes
FASTEST, FOURTH, BEND, MET, MET_TIME, MET_SINCE, THIRD, TOP = 0, 1, 2, 3, 6, 7, 8, 9
TURN_ROW, TURN_ROW_OF_TOPS = 8, 16

# kinds: one row for all bodies of equal semi-axes, mass and moments. AXIS: see ccd/precession.py; ACROSS: the
# inverse moment of a STEADY motion; SPREAD: longest less shortest semi-axis; BENDING: (longest^2 - shortest^2) / shortest, for eq. (7);
# UNEQUAL: largest difference of two moments over the third; DEGREES: of rotation that collisions exchange, 0, 2 or 3;
# LEVEL: see Cells; POLE: which semi-axis vector tells the shape of a body of revolution, if its motion is not FREE, else GENERAL;
# ACROSS_SQUARE, ALONG_SQUARE: of the semi-axes; HULL: about which of its axes the least body of revolution turns that holds it
# (sieve.py); HULL_ACROSS, HULL_ALONG: squares of that one's semi-axes; FREE_MOMENTS: inverse moments of a FREE motion, 0 of any other;
# STRAYING: by which the squared moves of the semi-axis vectors make the squared angle by which the shape has turned
SEMI_AXES, INVERSE_MASS, INVERSE_MOMENTS, AXIS, ACROSS, SPREAD, LARGEST, BENDING, MARGIN_LENGTH = 0, 3, 4, 7, 8, 9, 10, 11, 12
MOTION, UNEQUAL, DEGREES, LEVEL = 13, 14, 15, 16
POLE, ACROSS_SQUARE, ALONG_SQUARE = 17, 18, 19
HULL, HULL_ACROSS, HULL_ALONG = 20, 21, 22
FREE_MOMENTS, STRAYING = 23, 26
KIND_ROW = 32
GENERAL = -1

# motions: how a shape moves in free flight: not at all, at the constant rate L / I_perp (eq. (12)), or as a free top (eq. (12b))
STILL, STEADY, FREE = 0, 1, 2

# anchors: where a body was to be, at which size, when its list was made; SEEN: the rebuild that saw the body last
ANCHOR_POSITION, ANCHOR_RADIUS, ANCHOR_MARGIN, ANCHOR_SIZE, SEEN, ANCHOR_VECTORS = 0, 3, 4, 5, 6, 7
ANCHOR_ROW = 16

# entries of the neighbour lists: one cache line for each neighbour of each body, which four arrays of different types show.
# numbers: the partner's side of the gap (prediction.py) as it was at SINCE, and the pair's EVENT time; directions: NORMAL, towards the
# partner; images: the partner is this many cell vectors away from where it is stored; links: the partner, and the pair's entry in its list
SIDE, SIDE_RATE, SIDE_BEND, SINCE, EVENT = 2, 3, 4, 5, 6
NORMAL, IMAGE, PARTNER, TWIN = 0, 12, 14, 15
ENTRY_ROW = 8

# levels of the cells: layers in each direction, and the FIRST_CELL; HITS: bodies looked into together
FIRST_CELL = 3
LEVEL_ROW = 4
HITS = 128

# places of a cell, in blocks of LANES bodies, in columns: position from the corner, hull and margin in units of the level's longest list
# radius at size 1; GAP: what the search last said of each (sieve.py), nothing to keep; NOBODY: the first coordinate in an empty slot
LANES, NOBODY = 8, 1e12
(PLACE_POSITION, PLACE_AXIS, PLACE_ACROSS, PLACE_ALONG, PLACE_MARGIN, PLACE_GAP,
 BLOCK_ROW) = (LANES * column for column in (0, 3, 6, 7, 8, 9, 10))

# spans: where the list of a body stands among the entries, one behind the other in the order of the bodies, each with room up to the next
# (behind them all stands an empty one), and what the body waits for: a SLOT of its list, or its escape. AWAITED: who stood there, itself
# for its escape; ESCAPE_TIME, of `escapes`, the same memory; MET_PARTNER and MET_IMAGE: the pair whose contact is known
BEGIN, COUNT, AWAITED, SLOT, MET_PARTNER, MET_IMAGE = 0, 1, 2, 3, 4, 5
SPAN_ROW, ESCAPE_TIME = 8, 3

# clock: NOW and every time in the world count from EPOCH. REACH_SIZE: the largest size of an anchor. REFINE: a time, see tolerances.
# ENERGY: of the motions that collisions exchange; ENERGY_TIME: its time integral up to ENERGY_SINCE; it and VIRIAL are sums of this epoch,
# which began after EPOCH_BEGAN collisions. ENERGY_ERROR: sum over the epochs of the amounts by which ENERGY, as the collisions account for
# it, had come off what it is, in units of what it was when it was last counted, ENERGY_BEGAN. INSTANT: a span that is no progress.
# ROUNDING: of a position in the cell. LATEST: when the epoch ends, for the resolution of times. DRIFT: common velocity of all bodies, (3,)
(NOW, EPOCH, SIZE, GROWTH, REFINE, HORIZON, VIRIAL, ENERGY, ENERGY_TIME, ENERGY_SINCE, REACH_SIZE, ENERGY_ERROR, ENERGY_BEGAN,
 INSTANT, ROUNDING, LATEST, DRIFT) = range(17)
CLOCK_ROW = 24

# tally. SPARED: collisions that the TC model made elastic (EPOCH_SPARED: before this
# epoch). FAINT: weight of the last collisions in a row that were too faint to be told from rounding, the last of them of the FAINT_PAIR.
# WATCHED: how many entries are to be watched in this event. ENOUGH: the epoch ends with this look at the latest
(COLLISIONS, NEXT_EPOCH, EPOCH_BEGAN, EVENTS, LOOKS, REBUILDS, STANDING, SPARED, EPOCH_SPARED, FAINT, FAINT_PAIR, WATCHED,
 ENOUGH) = range(13)
TALLY_ROW = 16
WATCHED_ROOM = 256


class Lists(NamedTuple):
    """Neighbour lists. A pair's earliest possible contact stands in the list of the body that predicted it last, inf in the other."""

    spans: np.ndarray       # int32 (n + 1, SPAN_ROW)
    escapes: np.ndarray     # float64 (n + 1, SPAN_ROW / 2), the same memory
    numbers: np.ndarray     # float64 (entries, 8)
    directions: np.ndarray  # float32 (entries, 16), the same memory
    links: np.ndarray       # int32 (entries, 16), the same memory
    images: np.ndarray      # int8 (entries, 64), the same memory


class Grid(NamedTuple):
    """The periodic cell."""

    box: np.ndarray         # float64 (3, 3), rows are the cell vectors
    inverse: np.ndarray     # float64 (3, 3)
    heights: np.ndarray     # float64 (4,), distances of opposite faces; the smallest |x|^2 / (squared distances from three faces of x)


class Cells(NamedTuple):
    """Grids that hold the bodies by their anchors, one for each level of size (cells.py)."""

    levels: np.ndarray      # int64 (levels, LEVEL_ROW)
    reaches: np.ndarray     # float64 (levels, 2): longest list radius at size 1, and in units of it the sum of the edges of a cell
    places: np.ndarray      # float32 (cells, room / LANES, BLOCK_ROW)
    bodies: np.ndarray      # int32 (cells, room)
    count: np.ndarray       # int32 (cells,)
    where: np.ndarray       # int32 (n, 2): cell and slot of each body, -1: not placed
    hits: np.ndarray        # int64 (HITS + room,): bodies found and the images they are in, nothing to keep


class Calendar(NamedTuple):
    """A tournament of the next events of the bodies (calendar.py): the earliest of all stands first."""

    time: np.ndarray        # float64 (places,)
    body: np.ndarray        # int32 (places,)
    rounds: np.ndarray      # int64 (rounds,): the first place of each


class Contacts(NamedTuple):
    """What the rule of the collisions needs."""

    rule: np.ndarray        # float64 (RULE_ROW,), see edmd/rules/kinds.py
    last: np.ndarray        # float64 (n,), or (0,) without a contact time: time of a body's last collision, -inf before


class World(NamedTuple):
    bodies: np.ndarray      # float64 (n, BODY_ROW)
    kinds: np.ndarray       # float64 (kinds, KIND_ROW)
    image: np.ndarray       # int32 (n, 3)
    turns: np.ndarray       # float64 (n, TURN_ROW), or (n, TURN_ROW_OF_TOPS) if one is FREE
    anchors: np.ndarray     # float64 (n, ANCHOR_ROW)
    lists: Lists
    grid: Grid
    cells: Cells
    calendar: Calendar
    clock: np.ndarray       # float64 (CLOCK_ROW,)
    tally: np.ndarray       # int64 (TALLY_ROW,)
    contacts: Contacts
    columns: np.ndarray     # float64: where `prediction.predict` works, nothing to keep
    watched: np.ndarray     # int32 (WATCHED_ROOM,): entries to be watched in this event, nothing to keep
