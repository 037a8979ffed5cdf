"""The periodic upkeep of a world, at fixed numbers of collisions so that it never depends on who looks: times are counted from a new epoch
(their resolution stays that of the present), and with growth the temperature is brought back to kT = 1.
"""

from math import inf, sqrt

from ccd.compiling import kernel
from ccd.first_contact import curvature
from ccd.vectors import add_scaled, dot, load, scale, store, subtract
from edmd.flight import advance_all
from edmd.neighbors import DONE, rebuild, set_escape
from edmd.prediction import predict, reschedule, size_now
from edmd.rules.kinds import ELASTIC, KIND, ROUGH, set_contact_time
from edmd.spin import own_spin, rotational_energy, symmetry_axis
from edmd.state import (
    ANCHOR_POSITION,
    BEND,
    COLLISIONS,
    DRIFT,
    ENERGY,
    ENERGY_BEGAN,
    ENERGY_ERROR,
    ENERGY_SINCE,
    ENERGY_TIME,
    EPOCH,
    EPOCH_BEGAN,
    EPOCH_SPARED,
    ESCAPE_TIME,
    FREE_PAIRS,
    GROWTH,
    HORIZON,
    INSTANT,
    INVERSE_INERTIA,
    INVERSE_MASS,
    LARGEST,
    NEXT_EPOCH,
    NOW,
    REACH_SIZE,
    REFINE,
    SEMI_AXES,
    SIZE,
    SPARED,
    TIME,
    TURNING,
    VECTORS,
    VELOCITY,
    VIRIAL,
)
from edmd.tolerances import DRIFTED, EPOCH_COLLISIONS, EPOCH_LEAST, GROWTH_HORIZON, INSTANT_SHARE, REFINE_BELOW


@kernel
def start_epoch(world):
    """Count every time, and every sum, from now on. The mean free time of the epoch that ends decides when planes are renewed."""
    clock, tally, n = world.clock, world.tally, len(world.bodies)
    now, collisions = clock[NOW], tally[COLLISIONS] - tally[EPOCH_BEGAN]
    free = collisions - (tally[SPARED] - tally[EPOCH_SPARED])
    if free > 0 and now > 0:
        clock[REFINE] = REFINE_BELOW * now * n / (2.0 * free)
    _close_the_books(world)
    tally[EPOCH_BEGAN], tally[EPOCH_SPARED] = tally[COLLISIONS], tally[SPARED]
    tally[NEXT_EPOCH] = tally[COLLISIONS] + max(EPOCH_COLLISIONS * n, EPOCH_LEAST)
    clock[SIZE] = size_now(clock)
    clock[EPOCH] += now
    clock[NOW] = clock[ENERGY_SINCE] = clock[ENERGY_TIME] = clock[VIRIAL] = 0.0
    for body in range(n):
        world.bodies[body, TIME] -= now
        world.contacts.last[body] -= now
        if world.contacts.rule[KIND] == ROUGH:
            world.contacts.phase[body] += now * own_spin(world.bodies[body], world.contacts.inverse_moments[body])
        world.anchors[body, ESCAPE_TIME] -= now
        for slot in range(world.lists.count[body]):
            world.lists.time[body, slot] -= now
    for node in range(len(world.calendar.time)):
        world.calendar.time[node] -= now


@kernel
def _close_the_books(world):
    """Begin the epoch with the energy that is there, so that what collisions account for keeps its digits while a gas cools by decades."""
    clock, energy = world.clock, kinetic_energy(world)
    if clock[ENERGY_BEGAN] > 0:
        clock[ENERGY_ERROR] += (clock[ENERGY] - energy) / max(clock[ENERGY_BEGAN], energy)
    clock[ENERGY] = energy
    energy_counted(world)
    _take_back_drift(world)


@kernel
def mean_velocity(world):
    """Total mass, and velocity of its centre."""
    mass, momentum = 0.0, (0.0, 0.0, 0.0)
    for body in range(len(world.bodies)):
        row = world.bodies[body]
        mass += 1 / row[INVERSE_MASS]
        momentum = add_scaled(momentum, 1 / row[INVERSE_MASS], load(row, VELOCITY))
    return mass, scale(1 / mass, momentum)


@kernel
def _take_back_drift(world):
    """Momentum is kept to the rounding of the fastest velocities there were. In a gas that cools by thirty decades that becomes a drift."""
    clock = world.clock
    mass, velocity = mean_velocity(world)
    drift = subtract(velocity, load(clock, DRIFT))
    if 0.5 * mass * dot(drift, drift) <= DRIFTED * clock[ENERGY]:
        return
    advance_all(world.bodies, clock[NOW])
    for body in range(len(world.bodies)):
        store(world.bodies[body], VELOCITY, subtract(load(world.bodies[body], VELOCITY), drift))
    predict_all(world)


@kernel
def energy_counted(world):
    """What follows from a newly counted energy: the contact time in force, and an instant. Events of a collapsing gas crowd into less."""
    clock, longest = world.clock, 0.0
    mass, _ = mean_velocity(world)
    for body in range(len(world.bodies)):
        longest = max(longest, world.bodies[body, LARGEST] * size_now(clock))
    thermal_time = longest * sqrt(0.5 * mass / clock[ENERGY]) if clock[ENERGY] > 0 else 0.0
    clock[ENERGY_BEGAN] = clock[ENERGY]
    set_contact_time(world.contacts.rule, thermal_time)
    clock[INSTANT] = INSTANT_SHARE * thermal_time if world.contacts.rule[KIND] != ELASTIC and clock[GROWTH] == 0.0 else 0.0


@kernel
def active_turning(row):
    """The part of the angular velocity that collisions change: for a body of revolution the part across its axis."""
    turning, axis = load(row, TURNING), symmetry_axis(row)
    if axis == 4:
        return (0.0, 0.0, 0.0)
    if axis == 3:
        return turning
    along = load(row, VECTORS + 3 * axis)
    return add_scaled(turning, -dot(turning, along) / dot(along, along), along)


@kernel
def kinetic_energy(world):
    """Energy of all motions that collisions exchange: not that of the common drift, nor of the spin of smooth bodies of revolution."""
    contacts, energy = world.contacts, 0.0
    _, drift = mean_velocity(world)
    for body in range(len(world.bodies)):
        row = world.bodies[body]
        velocity = subtract(load(row, VELOCITY), drift)
        energy += 0.5 * dot(velocity, velocity) / row[INVERSE_MASS]
        if contacts.rule[KIND] == ROUGH:
            energy += rotational_energy(row, contacts.inverse_moments[body])
        elif row[INVERSE_INERTIA] > 0:
            turning = active_turning(row)
            energy += 0.5 * dot(turning, turning) / row[INVERSE_INERTIA]
    return energy


@kernel
def rescale(world, factor, inertia_factor):
    """Multiply the exchanged velocities by a factor; moments of inertia by another, at unchanged energy. Predictions are made anew."""
    advance_all(world.bodies, world.clock[NOW])
    store(world.clock, DRIFT, scale(factor, load(world.clock, DRIFT)))
    for body in range(len(world.bodies)):
        row = world.bodies[body]
        store(row, VELOCITY, scale(factor, load(row, VELOCITY)))
        row[INVERSE_INERTIA] /= inertia_factor
        for k in range(3):
            world.contacts.inverse_moments[body, k] /= inertia_factor
        turning = load(row, TURNING) if world.contacts.rule[KIND] == ROUGH else active_turning(row)
        store(row, TURNING, add_scaled(load(row, TURNING), factor / sqrt(inertia_factor) - 1, turning))
        row[BEND] = curvature(load(row, SEMI_AXES), load(row, TURNING))
    predict_all(world)


@kernel
def predict_all(world):
    """Every prediction anew, for the velocities and the growth of now."""
    world.clock[ENERGY_TIME] += world.clock[ENERGY] * (world.clock[NOW] - world.clock[ENERGY_SINCE])
    world.clock[ENERGY_SINCE] = world.clock[NOW]
    world.clock[ENERGY] = kinetic_energy(world)
    energy_counted(world)
    advance_all(world.bodies, world.clock[NOW])
    for body in range(len(world.bodies)):
        predict(world, body)
        set_escape(world, body)
    reschedule_all(world)


@kernel
def reschedule_all(world):
    for body in range(len(world.bodies)):
        reschedule(world, body)


@kernel
def rebuild_all(world):
    """Every list anew. -> DONE or why it could not be."""
    world.clock[REACH_SIZE] = 0.0
    advance_all(world.bodies, world.clock[NOW])
    rows = len(world.pairs.free)
    world.tally[FREE_PAIRS] = rows
    for k in range(rows):
        world.pairs.free[k] = rows - 1 - k
    for body in range(len(world.bodies)):
        world.lists.count[body] = 0
        world.anchors[body, ANCHOR_POSITION] = inf
    for body in range(len(world.bodies)):
        status = rebuild(world, body)
        if status != DONE:
            return status
    return DONE


@kernel
def set_growth(world, growth):
    """Let all semi-axes grow at this rate, in units of those at size 1, from now on; lists and predictions are made anew."""
    clock = world.clock
    clock[SIZE] = size_now(clock) - growth * clock[NOW]
    clock[GROWTH] = growth
    clock[HORIZON] = GROWTH_HORIZON * size_now(clock) / abs(growth) if growth != 0 else 1e300
    status = rebuild_all(world)
    if status == DONE:
        predict_all(world)
    return status
