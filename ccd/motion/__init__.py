"""Motions of a body in time."""

from ccd.motion.flight import FreeFlight, Rest
from ccd.motion.interpolation import approximate_flight, interpolate_affine, interpolate_rigid
from ccd.motion.rational import AffineInterpolant, AffineMotion, RationalMotion

Motion = RationalMotion | AffineMotion | AffineInterpolant | FreeFlight

__all__ = ["AffineInterpolant", "AffineMotion", "FreeFlight", "Motion", "RationalMotion", "Rest", "approximate_flight",
           "interpolate_affine", "interpolate_rigid"]
