"""Rough, eq. (29): part of the tangential velocity at the contact is stopped or reversed too, and spin is exchanged.

Chatterjee and Ruina, J. Appl. Mech. 65, 939 (1998): P = (1 + e) J_n + (1 + beta) (J - J_n). J_n is the impulse along the normal that stops
the approach, J the one that stops the contact altogether. Of spheres the tangential velocity then becomes -beta times what it was. Of
other bodies an impulse along the normal changes the tangential velocity too; what J_n leaves of it becomes -beta times as much. To reverse
the tangential velocity as it came in would create energy.
"""

from dataclasses import dataclass
from typing import Annotated

from ccd.compiling import kernel
from ccd.vectors import add_scaled, dot, scale
from edmd.rules.rule import ContactShare, ContactTime, Rule, Share, number


@dataclass(frozen=True)
class Rough(Rule):
    """rough, with constant normal and tangential restitution: all rotation takes part"""

    kind = "rough"
    restitution: Share = 0.9
    tangential_restitution: Annotated[float, "beta: -1 smooth, 0 sticking, 1 the tangential velocity is reversed",
                                      number("a number from -1 to 1", at_least=-1, at_most=1)] = 0.0
    contact_time: ContactTime = 0.0
    contact_share: ContactShare = 0.0


@kernel
def impulse(n, velocity, inverse_mass, matrix, parameters):
    """-> the impulse on the body that n points to, and the energy that is lost.

    velocity: of its surface against the other's at the contact, n.velocity < 0; matrix: the symmetric map (xx, yy, zz, yz, zx, xy) from an
    impulse to the change of that velocity; inverse_mass: n.(matrix n); parameters: (e, beta).
    """
    approach = -dot(n, velocity)
    stop = approach / inverse_mass
    slide = add_scaled(velocity, stop, times(matrix, n))            # what an impulse along n that stops the approach leaves
    against = solved(matrix, slide)
    along, across = 1 + parameters[0], 1 + parameters[1]
    lost = 0.5 * (along * (1 - parameters[0]) * stop * approach + across * (1 - parameters[1]) * dot(slide, against))
    return add_scaled(scale(along * stop, n), -across, against), lost


@kernel
def times(matrix, a):
    """A symmetric matrix (xx, yy, zz, yz, zx, xy) times a vector."""
    xx, yy, zz, yz, zx, xy = matrix
    return (xx * a[0] + xy * a[1] + zx * a[2], xy * a[0] + yy * a[1] + yz * a[2], zx * a[0] + yz * a[1] + zz * a[2])


@kernel
def solved(matrix, a):
    """x with matrix x = a, by the cofactors."""
    xx, yy, zz, yz, zx, xy = matrix
    cofactors = (yy * zz - yz * yz, xx * zz - zx * zx, xx * yy - xy * xy, xy * zx - xx * yz, xy * yz - yy * zx, yz * zx - zz * xy)
    determinant = xx * cofactors[0] + xy * cofactors[5] + zx * cofactors[4]
    return scale(1 / determinant, times(cofactors, a))
