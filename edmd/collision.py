"""Apply the impulse of a contact to both bodies."""

from ccd.compiling import kernel
from ccd.first_contact import curvature
from ccd.separation import support, support_point
from ccd.vectors import add, add_scaled, cross, dot, load, norm, scale, store, subtract
from edmd.flight import load_vectors
from edmd.prediction import size_now
from edmd.rules import elastic, rough
from edmd.rules.kinds import CONTACT_TIME, ELASTIC, KIND, PARAMETERS, ROUGH, smooth_restitution
from edmd.spin import angular_velocity, own_spin, yielding
from edmd.state import (
    BEND,
    BODY_A,
    BODY_B,
    COLLISIONS,
    ENERGY,
    ENERGY_SINCE,
    ENERGY_TIME,
    FAINT,
    FAINT_PAIR,
    GROWTH,
    INVERSE_INERTIA,
    INVERSE_MASS,
    NORMAL,
    NOW,
    SEMI_AXES,
    SPARED,
    TURNING,
    VECTORS,
    VELOCITY,
    VIRIAL,
)
from edmd.tolerances import FAINT_CHANGE, FAINTEST


@kernel
def _kick(row, n, arm, impulse):
    """Impulse along n with torque impulse * arm, arm = lever x n."""
    store(row, VELOCITY, add_scaled(load(row, VELOCITY), impulse * row[INVERSE_MASS], n))
    turning = add_scaled(load(row, TURNING), impulse * row[INVERSE_INERTIA], arm)
    store(row, TURNING, turning)
    row[BEND] = curvature(load(row, SEMI_AXES), turning)


@kernel
def collide(world, pair, rate):
    """The pair touches now, both bodies up to date; rate is that of their gap, growth and rotation included."""
    clock, link = world.clock, world.pairs.link[pair]
    a, b = world.bodies[link[BODY_A]], world.bodies[link[BODY_B]]
    n = load(world.pairs.plane[pair], NORMAL)
    s_a, s_b, size = load_vectors(a, VECTORS), load_vectors(b, VECTORS), size_now(clock)
    lever_a, lever_b = scale(size, support_point(s_a, n)), scale(-size, support_point(s_b, n))
    arm_a, arm_b = cross(lever_a, n), cross(lever_b, n)
    # n is unit up to rounding only: its square keeps the energy, which would otherwise drift one way
    inverse_mass = ((a[INVERSE_MASS] + b[INVERSE_MASS]) * dot(n, n)
                    + a[INVERSE_INERTIA] * dot(arm_a, arm_a) + b[INVERSE_INERTIA] * dot(arm_b, arm_b))
    supports = support(s_a, n) + support(s_b, n)
    impulse, lost = elastic.impulse(-rate, inverse_mass), 0.0
    kind = int(world.contacts.rule[KIND])
    if kind != ELASTIC and not _spared(world, link[BODY_A], link[BODY_B]):
        _notice_faint(world, pair, rate)
        if kind == ROUGH:
            _rub(world, pair, (lever_a, lever_b), clock[GROWTH] * supports)
            return
        left = smooth_restitution(world.contacts.rule, -rate)
        lost = -0.25 * (1 - left * left) * rate * impulse
        impulse *= 0.5 * (1 + left)
    _kick(a, n, arm_a, -impulse)
    _kick(b, n, arm_b, impulse)
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


@kernel
def _notice_faint(world, pair, rate):
    """Weigh collisions in a row whose approach is lost in the rounding of the velocities it is the difference of."""
    tally, link = world.tally, world.pairs.link[pair]
    a, b = world.bodies[link[BODY_A]], world.bodies[link[BODY_B]]
    if -rate >= FAINTEST * max(norm(load(a, VELOCITY)), norm(load(b, VELOCITY))):
        tally[FAINT] = 0
    else:
        tally[FAINT] += 1 if tally[FAINT] == 0 or pair == tally[FAINT_PAIR] else FAINT_CHANGE
        tally[FAINT_PAIR] = pair


@kernel
def _rub(world, pair, levers, growth):
    """A rough collision: an impulse in any direction. growth: speed at which growing surfaces approach each other."""
    contacts, link, now = world.contacts, world.pairs.link[pair], world.clock[NOW]
    one, other = link[BODY_A], link[BODY_B]
    a, b, inverse_a, inverse_b = world.bodies[one], world.bodies[other], contacts.inverse_moments[one], contacts.inverse_moments[other]
    n = load(world.pairs.plane[pair], NORMAL)
    surface_a = add(load(a, VELOCITY), cross(angular_velocity(a, inverse_a), levers[0]))
    surface_b = add(load(b, VELOCITY), cross(angular_velocity(b, inverse_b), levers[1]))
    velocity = add_scaled(subtract(surface_b, surface_a), -growth / dot(n, n), n)
    m_a, m_b = yielding(a, a[INVERSE_MASS], inverse_a, levers[0]), yielding(b, b[INVERSE_MASS], inverse_b, levers[1])
    matrix = (m_a[0] + m_b[0], m_a[1] + m_b[1], m_a[2] + m_b[2], m_a[3] + m_b[3], m_a[4] + m_b[4], m_a[5] + m_b[5])
    impulse, lost = rough.impulse(n, velocity, dot(n, rough.times(matrix, n)), matrix, contacts.rule[PARAMETERS:])
    contacts.phase[one] += now * own_spin(a, inverse_a)
    contacts.phase[other] += now * own_spin(b, inverse_b)
    _kick(a, impulse, cross(levers[0], impulse), -1.0)
    _kick(b, impulse, cross(levers[1], impulse), 1.0)
    contacts.phase[one] -= now * own_spin(a, inverse_a)
    contacts.phase[other] -= now * own_spin(b, inverse_b)
    _record(world, dot(impulse, subtract(levers[0], levers[1])), growth * dot(n, impulse) - lost)


@kernel
def _record(world, virial, gain):
    """Count the collision: its virial, impulse times distance of the centres, and its energy, work of growing surfaces less the loss."""
    clock = world.clock
    clock[ENERGY_TIME] += clock[ENERGY] * (clock[NOW] - clock[ENERGY_SINCE])
    clock[ENERGY_SINCE] = clock[NOW]
    clock[ENERGY] += gain
    clock[VIRIAL] += virial
    world.tally[COLLISIONS] += 1
