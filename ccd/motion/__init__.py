"""Motions of a body in time."""

from ccd.motion.flight import FreeFlight, Rest

__all__ = ["FreeFlight", "Rest"]
