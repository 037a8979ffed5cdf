"""The one vocabulary of the engine: what can happen to a body, and why a block of events ends."""

from enum import IntEnum


class EventKind(IntEnum):
    """What a body waits for: its calendar entry holds a slot of its neighbour list (a pair to look at), or one of these."""

    ESCAPE = -1         # it may have left the neighbourhood its list was made for


class Ended(IntEnum):
    """Why the engine gave control back."""

    TIME = 0                # the wanted time is reached
    COLLISIONS = 1          # the wanted number of collisions is reached
    EPOCH = 2               # time for the periodic upkeep (edmd/epoch.py)
    NO_ROOM = 3             # a neighbour list or a cell of a grid needs more room; nothing is lost, enlarge and go on
    CELL_TOO_SMALL = 4      # a body has come near its own periodic image
    PAUSED = 5              # many events went by; Python may want to look for an interrupt
    STALLED = 6             # events go on but time stands still, or collisions that are nothing but rounding
    AT_REST = 7             # no event is to come, and no time at which to end
