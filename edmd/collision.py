"""Apply the impulse of a contact to both bodies."""

from ccd.compiling import kernel
from ccd.first_contact import curvature
from ccd.separation import support, support_point
from ccd.vectors import add_scaled, cross, dot, load, scale, store
from edmd.flight import load_vectors
from edmd.prediction import size_now
from edmd.rules import elastic
from edmd.state import (
    BEND,
    BODY_A,
    BODY_B,
    COLLISIONS,
    ENERGY,
    ENERGY_SINCE,
    ENERGY_TIME,
    GROWTH,
    INVERSE_INERTIA,
    INVERSE_MASS,
    NORMAL,
    NOW,
    SEMI_AXES,
    TURNING,
    VECTORS,
    VELOCITY,
    VIRIAL,
)


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
    arm_a, arm_b = cross(scale(size, support_point(s_a, n)), n), cross(scale(-size, support_point(s_b, n)), n)
    # n is unit up to rounding only: its square keeps the energy, which would otherwise drift one way
    inverse_mass = ((a[INVERSE_MASS] + b[INVERSE_MASS]) * dot(n, n)
                    + a[INVERSE_INERTIA] * dot(arm_a, arm_a) + b[INVERSE_INERTIA] * dot(arm_b, arm_b))
    impulse = elastic.impulse(-rate, inverse_mass)
    _kick(a, n, arm_a, -impulse)
    _kick(b, n, arm_b, impulse)
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
