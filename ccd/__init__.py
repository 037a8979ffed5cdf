"""Continuous collision detection for ellipsoids: two bodies, one question. Knows nothing of many bodies."""

from ccd import batch
from ccd.batch import Bodies
from ccd.ellipsoid import AffineEllipsoid, Ellipsoid
from ccd.motion import FreeFlight, Rest
from ccd.overlap import characteristic_polynomial, contact_point, state
from ccd.queries import Contact, Separation, first_contact, separation
from ccd.status import State, Status

__all__ = ["AffineEllipsoid", "Bodies", "Contact", "Ellipsoid", "FreeFlight", "Rest", "Separation", "State", "Status", "batch",
           "characteristic_polynomial", "contact_point", "first_contact", "separation", "state"]
