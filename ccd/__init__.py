"""Continuous collision detection for ellipsoids: two bodies, one question. Knows nothing of many bodies."""

from ccd import batch
from ccd.batch import Bodies
from ccd.ellipsoid import Ellipsoid
from ccd.motion import FreeFlight, Rest
from ccd.queries import Contact, Separation, first_contact, separation
from ccd.status import State, Status

__all__ = ["Bodies", "Contact", "Ellipsoid", "FreeFlight", "Rest", "Separation", "State", "Status", "batch", "first_contact", "separation"]
