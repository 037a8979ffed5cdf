"""Smooth and inelastic, eq. (26): a constant part of the approach velocity is left."""

from dataclasses import dataclass

from ccd.compiling import kernel
from edmd.rules.rule import ContactShare, ContactTime, Rule, Share


@dataclass(frozen=True)
class Inelastic(Rule):
    """smooth, with a constant normal restitution"""

    kind = "inelastic"
    restitution: Share = 0.9
    contact_time: ContactTime = 0.0
    contact_share: ContactShare = 0.0


@kernel
def restitution(approach, parameters):
    """e, whatever the approach velocity; parameters: (e,)."""
    return parameters[0]
