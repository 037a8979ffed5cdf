"""Apply the impulse of a contact to both bodies."""

from ccd.compiling import kernel
from ccd.separation import support, support_point
from ccd.vectors import add_scaled, cross, dot, load, scale, store
from edmd.flight import kind_of, load_vectors, turning
from edmd.prediction import size_now
from edmd.rules import elastic
from edmd.state import (
    COLLISIONS,
    ENERGY,
    ENERGY_SINCE,
    ENERGY_TIME,
    GROWTH,
    INVERSE_MASS,
    MOMENTUM,
    NOW,
    VECTORS,
    VELOCITY,
    VIRIAL,
)


@kernel
def _kick(row, kind, n, arm, impulse):
    """Impulse along n with torque impulse * arm, arm = lever x n."""
    store(row, VELOCITY, add_scaled(load(row, VELOCITY), impulse * kind[INVERSE_MASS], n))
    store(row, MOMENTUM, add_scaled(load(row, MOMENTUM), impulse, arm))


@kernel
def collide(world, body, partner, n, rate):
    """Two bodies touch now, both up to date; n: the normal from one to the other, rate: of their gap, growth and rotation included."""
    clock = world.clock
    a, b = world.bodies[body], world.bodies[partner]
    kind_a, kind_b = world.kinds[kind_of(world, body)], world.kinds[kind_of(world, partner)]
    s_a, s_b, size = load_vectors(a, VECTORS), load_vectors(b, VECTORS), size_now(clock)
    arm_a, arm_b = cross(scale(size, support_point(s_a, n)), n), cross(scale(-size, support_point(s_b, n)), n)
    # n is unit up to rounding only: its square keeps the energy, which would otherwise drift one way
    inverse_mass = ((kind_a[INVERSE_MASS] + kind_b[INVERSE_MASS]) * dot(n, n)
                    + dot(arm_a, turning(a, kind_a, arm_a)) + dot(arm_b, turning(b, kind_b, arm_b)))
    impulse = elastic.impulse(-rate, inverse_mass)
    _kick(a, kind_a, n, arm_a, -impulse)
    _kick(b, kind_b, n, arm_b, impulse)
    _record(world, impulse, support(s_a, n) + support(s_b, n))


@kernel
def _record(world, impulse, supports):
    """Count the collision: virial (impulse times distance along the normal), and the work of the growing surfaces."""
    clock = world.clock
    clock[ENERGY_TIME] += clock[ENERGY] * (clock[NOW] - clock[ENERGY_SINCE])
    clock[ENERGY_SINCE] = clock[NOW]
    clock[ENERGY] += clock[GROWTH] * supports * impulse
    clock[VIRIAL] += impulse * supports * size_now(clock)
    world.tally[COLLISIONS] += 1
