"""Smooth and elastic: the normal velocity of the contact is reversed."""

from dataclasses import dataclass

from ccd.compiling import kernel
from edmd.rules.rule import Rule


@dataclass(frozen=True)
class Elastic(Rule):
    """smooth and elastic: energy is conserved"""

    kind = "elastic"


@kernel
def impulse(approach, inverse_mass):
    """Size of the impulse along the normal from the approach velocity and the inverse of the effective mass of the contact."""
    return 2 * approach / inverse_mass
