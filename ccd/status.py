"""The answers of the collision detection."""

from enum import IntEnum


class State(IntEnum):
    """Two ellipsoids at rest (paper, Sec. 2), or throughout an interval of time; then UNRESOLVED says "could not tell"."""

    OVERLAPPING = -1
    TOUCHING = 0
    SEPARATE = 1
    UNRESOLVED = 2


class Status(IntEnum):
    """A search for the first contact. UNRESOLVED says "could not tell"; it is never a guess."""

    NO_CONTACT = 0
    CONTACT = 1
    OVERLAPPING = 2
    UNRESOLVED = 3
