"""Smooth and elastic: the normal velocity of the contact is reversed."""

from ccd.compiling import kernel


@kernel
def impulse(approach, inverse_mass):
    """Size of the impulse along the normal from the approach velocity and the inverse of the effective mass of the contact."""
    return 2 * approach / inverse_mass
