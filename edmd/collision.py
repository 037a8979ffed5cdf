"""Apply the impulse of a contact to both bodies."""

from ccd.compiling import kernel, large_kernel
from ccd.free_top import turning_of
from ccd.lanes import abreast, first, first_of, second, second_of, total, total_of, two
from ccd.separation import semi_axis_vectors, support, support_point
from ccd.vectors import add, add_scaled, cross, dot, load, norm, scale, subtract
from edmd.couple import arrive_both
from edmd.flight import arrive, both, each, kind_of, store_both, turning
from edmd.pairs import size_now
from edmd.rules import elastic, rough
from edmd.rules.kinds import CONTACT_TIME, ELASTIC, KIND, PARAMETERS, ROUGH, smooth_restitution
from edmd.state import (
    ACROSS,
    COLLISIONS,
    ENERGY,
    ENERGY_SINCE,
    ENERGY_TIME,
    FAINT,
    FAINT_PAIR,
    FREE,
    FREE_MOMENTS,
    GROWTH,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    LARGEST,
    MOMENTUM,
    MOTION,
    NOW,
    SEMI_AXES,
    SPARED,
    STILL,
    VELOCITY,
    VIRIAL,
)
from edmd.tolerances import FAINT_CHANGE, FAINTEST


@kernel
def collide(world, body, partner, n):
    """Two bodies touch now; n: the normal from one to the other."""
    clock, rule = world.clock, world.contacts.rule
    a, b = world.bodies[body], world.bodies[partner]
    kind_a, kind_b = world.kinds[kind_of(world, body)], world.kinds[kind_of(world, partner)]
    size, growth = size_now(clock), clock[GROWTH]
    supports, points, axes = _arrive(world, body, partner, n)
    levers = scale(two(size, -size), points)
    arms = cross(levers, n)
    twists = scale(each(kind_a, kind_b, ACROSS), arms)              # angular velocities that arms, as angular momenta, give
    if kind_a[MOTION] == FREE or kind_b[MOTION] == FREE:
        free_twists, _ = turning_of(axes, arms, both(kind_a, kind_b, FREE_MOMENTS))
        twists = add(twists, free_twists)
    straight, spinning = kind_a[INVERSE_MASS] + kind_b[INVERSE_MASS], dot(twists, both(a, b, MOMENTUM))
    inverse_mass = straight + total(dot(arms, twists))
    rate = dot(n, subtract(load(b, VELOCITY), load(a, VELOCITY))) + second(spinning) - first(spinning) - growth * supports
    rate = -abs(rate)                                   # they approach: what is above 0 is rounding
    # n is unit up to rounding only: what n.n has above 1 keeps the energy, and would be rounded, one way more often, if it were added to 1
    rate -= rate * straight * ((n[0] * n[0] - 1.0) + n[1] * n[1] + n[2] * n[2]) / inverse_mass
    impulse, lost = elastic.impulse(-rate, inverse_mass), 0.0
    kind = int(rule[KIND])
    if kind != ELASTIC and not _spared(world, body, partner):
        _notice_faint(world.tally, a, b, min(body, partner) * len(world.bodies) + max(body, partner), rate)
        if kind == ROUGH:
            virial, gain = _rub((a, b), (kind_a, kind_b), n, (levers, axes, growth * supports), rule)
            _record(world, virial, gain)
            return
        left = smooth_restitution(rule, -rate)
        lost = -0.25 * (1 - left * left) * rate * impulse
        impulse *= 0.5 * (1 + left)
    kick = two(-impulse, impulse)
    _kick((a, b), (kind_a, kind_b), scale(kick, n), scale(kick, arms))
    _record(world, impulse * supports * size, growth * supports * impulse - lost)


@kernel
def _arrive(world, body, partner, n):
    """Move both bodies to the present. -> the sum of their supports in direction n, the supporting points of both along n, their axes"""
    kind_a, kind_b = world.kinds[kind_of(world, body)], world.kinds[kind_of(world, partner)]
    if kind_a[MOTION] == STILL and kind_b[MOTION] == STILL:
        for one in (body, partner):
            arrive(world.bodies[one], world.turns[one], world.kinds[kind_of(world, one)], world.clock[NOW])
        radii, along, across = each(kind_a, kind_b, LARGEST), two(1.0, 1.0), two(0.0, 0.0)             # any axes: nobody asks for these
        return total(radii), scale(radii, n), ((along, across, across), (across, along, across), (across, across, along))
    axes = arrive_both(world, body, partner)
    vectors = semi_axis_vectors(both(kind_a, kind_b, SEMI_AXES), axes)
    return total(support(vectors, n)), support_point(vectors, n), axes


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
def _rub(rows, kinds, n, contact, rule):
    """A rough collision: an impulse in any direction. contact: levers and axes of both, and the speed at which growing surfaces approach
    each other. -> its virial and the energy gained, as for `_record`"""
    (a, b), (kind_a, kind_b), (levers, axes, growth) = rows, kinds, contact
    spins = abreast(turning(a, kind_a, load(a, MOMENTUM)), turning(b, kind_b, load(b, MOMENTUM)))
    surfaces = add(both(a, b, VELOCITY), cross(spins, levers))
    velocity = add_scaled(subtract(second_of(surfaces), first_of(surfaces)), -growth / dot(n, n), n)
    yielding = _yielding(axes, levers, each(kind_a, kind_b, INVERSE_MASS), both(kind_a, kind_b, INVERSE_MOMENTS))
    matrix = total_of(yielding[:3]) + total_of(yielding[3:])
    impulse, lost = rough.impulse(n, velocity, dot(n, rough.times(matrix, n)), matrix, rule[PARAMETERS:])
    impulses = scale(two(-1.0, 1.0), impulse)
    _kick(rows, kinds, impulses, cross(levers, impulses))
    return -total(dot(impulses, levers)), growth * dot(n, impulse) - lost


@kernel
def _yielding(axes, lever, inverse_mass, inverse_moments):
    """The symmetric matrix (xx, yy, zz, yz, zx, xy) from an impulse at lever from the centre to the change of velocity of that point:
    1 / m + sum over the principal axes e of q q^T / I, q = e x lever."""
    p, q, r = cross(axes[0], lever), cross(axes[1], lever), cross(axes[2], lever)
    i, j, k = inverse_moments
    return (inverse_mass + i * p[0] * p[0] + j * q[0] * q[0] + k * r[0] * r[0],
            inverse_mass + i * p[1] * p[1] + j * q[1] * q[1] + k * r[1] * r[1],
            inverse_mass + i * p[2] * p[2] + j * q[2] * q[2] + k * r[2] * r[2],
            i * p[1] * p[2] + j * q[1] * q[2] + k * r[1] * r[2],
            i * p[2] * p[0] + j * q[2] * q[0] + k * r[2] * r[0],
            i * p[0] * p[1] + j * q[0] * q[1] + k * r[0] * r[1])


@kernel
def _kick(rows, kinds, impulses, torques):
    """Impulses on both bodies, and their torques about the centres."""
    (a, b), (kind_a, kind_b) = rows, kinds
    store_both(a, b, VELOCITY, add_scaled(both(a, b, VELOCITY), each(kind_a, kind_b, INVERSE_MASS), impulses))
    store_both(a, b, MOMENTUM, add(both(a, b, MOMENTUM), torques))


@kernel
def _record(world, virial, gain):
    """Count the collision: its virial, impulse times distance of the centres, and its energy, work of growing surfaces less the loss."""
    clock = world.clock
    clock[ENERGY_TIME] += clock[ENERGY] * (clock[NOW] - clock[ENERGY_SINCE])
    clock[ENERGY_SINCE] = clock[NOW]
    clock[ENERGY] += gain
    clock[VIRIAL] += virial
    world.tally[COLLISIONS] += 1
