"""Smooth viscoelastic spheres, eq. (27): e(v) = 1 - 1.15345 D v^(1/5) + 0.79827 D^2 v^(2/5) - ...

Hertz' contact with a dissipative force, m x'' = -rho (x^(3/2) + (3/2) A sqrt(x) x'), until the force has gone: D = (3/2) A (rho / m)^(2/5).
Series: Schwager and Poeschel, Phys. Rev. E 57, 650 (1998); Ramirez, Poeschel, Brilliantov and Schwager, ibid. 60, 4465 (1999). The
approximant below has its first terms and the right decay for fast impacts: Mueller and Poeschel, ibid. 84, 021302 (2011).
"""

from dataclasses import dataclass
from typing import Annotated

from ccd.compiling import kernel
from edmd.rules.rule import ContactShare, ContactTime, Rule, number

ABOVE = 0.501086
BELOW = (0.501086, 1.15345, 0.577977, 0.532178)


@dataclass(frozen=True)
class Viscoelastic(Rule):
    """smooth, restitution of viscoelastic spheres: the faster the impact, the more is lost"""

    kind = "viscoelastic"
    dissipation: Annotated[float, "D in e(v) = 1 - 1.15345 D v^(1/5) + ..., the same for every pair, in velocity^(-1/5)",
                           number("a number, 0 or more", at_least=0)] = 0.1
    contact_time: ContactTime = 0.0
    contact_share: ContactShare = 0.0


@kernel
def restitution(approach, parameters):
    """e(v) of an approach velocity v; parameters: (D,)."""
    square = parameters[0] * max(approach, 0.0)**0.2
    x = square**0.5
    return (1 + ABOVE * x) / (1 + x * (BELOW[0] + x * (BELOW[1] + x * (BELOW[2] + x * BELOW[3]))))
