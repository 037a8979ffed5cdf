"""Continuous collision detection for ellipsoids: two bodies, one question. Knows nothing of many bodies."""

from ccd import batch, scene
from ccd.answers import Contact, Interval, Separation
from ccd.batch import AffineBodies, Bodies
from ccd.ellipsoid import AffineEllipsoid, Ellipsoid
from ccd.equation import CCDEquation
from ccd.motion import AffineMotion, FreeFlight, RationalMotion, Rest, approximate_flight, interpolate_affine, interpolate_rigid
from ccd.overlap import characteristic_polynomial, contact_point, state
from ccd.queries import contact_intervals, first_contact, separation
from ccd.status import State, Status

__all__ = ["AffineBodies", "AffineEllipsoid", "AffineMotion", "Bodies", "CCDEquation", "Contact", "Ellipsoid", "FreeFlight", "Interval",
           "RationalMotion", "Rest", "Separation", "State", "Status", "approximate_flight", "batch", "characteristic_polynomial",
           "contact_intervals", "contact_point", "first_contact", "interpolate_affine", "interpolate_rigid", "scene", "separation", "state"]
