"""Smooth, softer as it is hit faster, eq. (28): e(v) = 1 - (1 - e) (v / V)^exponent up to v = V, e beyond.

Bizon, Shattuck, Swift, McCormick and Swinney, Phys. Rev. Lett. 80, 57 (1998), with exponent 3/4, e = 0.7 and V = sqrt(g d), which gives the
patterns of vibrated layers as they are measured. Exponent 1/5 is the leading term of viscoelastic spheres.
"""

from dataclasses import dataclass
from typing import Annotated

from ccd.compiling import kernel
from edmd.rules.rule import ContactShare, ContactTime, Rule, Share, number


@dataclass(frozen=True)
class PowerLaw(Rule):
    """smooth, restitution falling from 1 as a power of the impact velocity, to a floor"""

    kind = "power_law"
    restitution: Share = 0.7
    velocity: Annotated[float, "impact velocity from which on the restitution is at its floor",
                        number("a positive velocity", above=0)] = 1.0
    exponent: Annotated[float, "power of the impact velocity with which it falls", number("a positive number", above=0)] = 0.75
    contact_time: ContactTime = 0.0
    contact_share: ContactShare = 0.0


@kernel
def restitution(approach, parameters):
    """e(v) of an approach velocity v; parameters: (floor, velocity where it is reached, exponent)."""
    return 1.0 - (1.0 - parameters[0]) * min(approach / parameters[1], 1.0)**parameters[2]
