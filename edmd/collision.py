"""Apply the impulse of a contact to both bodies."""

from ccd.compiling import kernel, large_kernel
from ccd.rotation import body_axes, load_quaternion
from ccd.separation import support, support_point
from ccd.vectors import add, add_scaled, cross, dot, load, norm, scale, store, subtract
from edmd.flight import arrive, kind_of, load_vectors, turning
from edmd.pairs import size_now
from edmd.rules import elastic, rough
from edmd.rules.kinds import CONTACT_TIME, ELASTIC, KIND, PARAMETERS, ROUGH, smooth_restitution
from edmd.state import (
    COLLISIONS,
    ENERGY,
    ENERGY_SINCE,
    ENERGY_TIME,
    FAINT,
    FAINT_PAIR,
    GROWTH,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    MOMENTUM,
    NOW,
    ORIENTATION,
    SPARED,
    VECTORS,
    VELOCITY,
    VIRIAL,
)
from edmd.tolerances import FAINT_CHANGE, FAINTEST


@kernel
def _kick(row, kind, impulse, torque, sign):
    """An impulse and its torque about the centre, with this sign."""
    store(row, VELOCITY, add_scaled(load(row, VELOCITY), sign * kind[INVERSE_MASS], impulse))
    store(row, MOMENTUM, add_scaled(load(row, MOMENTUM), sign, torque))


@kernel
def collide(world, body, partner, n):
    """Two bodies touch now; n: the normal from one to the other."""
    clock = world.clock
    a, b = world.bodies[body], world.bodies[partner]
    kind_a, kind_b = world.kinds[kind_of(world, body)], world.kinds[kind_of(world, partner)]
    arrive(a, world.turns[body], kind_a, clock[NOW])
    arrive(b, world.turns[partner], kind_b, clock[NOW])
    s_a, s_b, size = load_vectors(a, VECTORS), load_vectors(b, VECTORS), size_now(clock)
    lever_a, lever_b = scale(size, support_point(s_a, n)), scale(-size, support_point(s_b, n))
    arm_a, arm_b = cross(lever_a, n), cross(lever_b, n)
    straight = kind_a[INVERSE_MASS] + kind_b[INVERSE_MASS]
    inverse_mass = straight + dot(arm_a, turning(a, kind_a, arm_a)) + dot(arm_b, turning(b, kind_b, arm_b))
    supports = support(s_a, n) + support(s_b, n)
    rate = (dot(n, subtract(load(b, VELOCITY), load(a, VELOCITY))) + dot(arm_b, turning(b, kind_b, load(b, MOMENTUM)))
            - dot(arm_a, turning(a, kind_a, load(a, MOMENTUM))) - clock[GROWTH] * supports)
    rate = -abs(rate)                                   # they approach: what is above 0 is rounding
    # n is unit up to rounding only: what n.n has above 1 keeps the energy, and would be rounded, one way more often, if it were added to 1
    rate -= rate * straight * ((n[0] * n[0] - 1.0) + n[1] * n[1] + n[2] * n[2]) / inverse_mass
    impulse, lost = elastic.impulse(-rate, inverse_mass), 0.0
    kind = int(world.contacts.rule[KIND])
    if kind != ELASTIC and not _spared(world, body, partner):
        _notice_faint(world.tally, a, b, min(body, partner) * len(world.bodies) + max(body, partner), rate)
        if kind == ROUGH:
            virial, gain = _rub(a, b, kind_a, kind_b, n, (lever_a, lever_b, clock[GROWTH] * supports), world.contacts.rule)
            _record(world, virial, gain)
            return
        left = smooth_restitution(world.contacts.rule, -rate)
        lost = -0.25 * (1 - left * left) * rate * impulse
        impulse *= 0.5 * (1 + left)
    _kick(a, kind_a, scale(impulse, n), scale(impulse, arm_a), -1.0)
    _kick(b, kind_b, scale(impulse, n), scale(impulse, arm_b), 1.0)
    _record(world, impulse * supports * size, clock[GROWTH] * supports * impulse - lost)


@kernel
def _spared(world, one, other):
    """TC model, eq. (30): whether the last collision of either is less than the contact time ago."""
    contacts, now = world.contacts, world.clock[NOW]
    if contacts.rule[CONTACT_TIME] == 0.0:
        return False
    last = max(contacts.last[one], contacts.last[other])
    contacts.last[one] = contacts.last[other] = now
    if now - last >= contacts.rule[CONTACT_TIME]:
        return False
    world.tally[SPARED] += 1
    return True


@large_kernel
def _notice_faint(tally, a, b, pair, rate):
    """Weigh collisions in a row whose approach is lost in the rounding of the velocities it is the difference of. pair: a name of it."""
    if -rate >= FAINTEST * max(norm(load(a, VELOCITY)), norm(load(b, VELOCITY))):
        tally[FAINT] = 0
    else:
        tally[FAINT] += 1 if tally[FAINT] == 0 or pair == tally[FAINT_PAIR] else FAINT_CHANGE
        tally[FAINT_PAIR] = pair


@large_kernel
def _rub(a, b, kind_a, kind_b, n, contact, rule):
    """A rough collision: an impulse in any direction. contact: both levers, and the speed at which growing surfaces approach each other.
    -> its virial and the energy gained, as for `_record`"""
    lever_a, lever_b, growth = contact
    surface_a = add(load(a, VELOCITY), cross(turning(a, kind_a, load(a, MOMENTUM)), lever_a))
    surface_b = add(load(b, VELOCITY), cross(turning(b, kind_b, load(b, MOMENTUM)), lever_b))
    velocity = add_scaled(subtract(surface_b, surface_a), -growth / dot(n, n), n)
    m_a, m_b = _yielding(a, kind_a, lever_a), _yielding(b, kind_b, lever_b)
    matrix = (m_a[0] + m_b[0], m_a[1] + m_b[1], m_a[2] + m_b[2], m_a[3] + m_b[3], m_a[4] + m_b[4], m_a[5] + m_b[5])
    impulse, lost = rough.impulse(n, velocity, dot(n, rough.times(matrix, n)), matrix, rule[PARAMETERS:])
    _kick(a, kind_a, impulse, cross(lever_a, impulse), -1.0)
    _kick(b, kind_b, impulse, cross(lever_b, impulse), 1.0)
    return dot(impulse, subtract(lever_a, lever_b)), growth * dot(n, impulse) - lost


@kernel
def _yielding(row, kind, lever):
    """The symmetric matrix (xx, yy, zz, yz, zx, xy) from an impulse at lever from the centre to the change of velocity of that point:
    1 / m + sum over the principal axes e of q q^T / I, q = e x lever."""
    axes = body_axes(load_quaternion(row, ORIENTATION))
    p, q, r = cross(axes[0], lever), cross(axes[1], lever), cross(axes[2], lever)
    (i, j, k), inverse_mass = load(kind, INVERSE_MOMENTS), kind[INVERSE_MASS]
    return (inverse_mass + i * p[0] * p[0] + j * q[0] * q[0] + k * r[0] * r[0],
            inverse_mass + i * p[1] * p[1] + j * q[1] * q[1] + k * r[1] * r[1],
            inverse_mass + i * p[2] * p[2] + j * q[2] * q[2] + k * r[2] * r[2],
            i * p[1] * p[2] + j * q[1] * q[2] + k * r[1] * r[2],
            i * p[2] * p[0] + j * q[2] * q[0] + k * r[2] * r[0],
            i * p[0] * p[1] + j * q[0] * q[1] + k * r[0] * r[1])


@kernel
def _record(world, virial, gain):
    """Count the collision: its virial, impulse times distance of the centres, and its energy, work of growing surfaces less the loss."""
    clock = world.clock
    clock[ENERGY_TIME] += clock[ENERGY] * (clock[NOW] - clock[ENERGY_SINCE])
    clock[ENERGY_SINCE] = clock[NOW]
    clock[ENERGY] += gain
    clock[VIRIAL] += virial
    world.tally[COLLISIONS] += 1
