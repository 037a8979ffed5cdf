"""The periodic upkeep of a world, at fixed numbers of collisions so that it never depends on who looks: times are counted from a new epoch
(their resolution stays that of the present), and with growth the temperature is brought back to kT = 1.
"""

from math import inf, sqrt

from ccd.compiling import kernel, large_kernel
from ccd.vectors import add_scaled, dot, load, scale, store, subtract
from edmd.flight import advance_all, kind_of, set_turning, turning
from edmd.neighbors import DONE, rebuild, set_escapes
from edmd.pairs import size_now
from edmd.prediction import predict, reschedule
from edmd.rules.kinds import ELASTIC, KIND, set_contact_time
from edmd.state import (
    ACROSS,
    ANCHOR_POSITION,
    AXIS,
    BEGIN,
    COLLISIONS,
    COUNT,
    DEGREES,
    DRIFT,
    ENERGY,
    ENERGY_BEGAN,
    ENERGY_ERROR,
    ENERGY_SINCE,
    ENERGY_TIME,
    ENOUGH,
    EPOCH,
    EPOCH_BEGAN,
    EPOCH_SPARED,
    ESCAPE_TIME,
    EVENT,
    FREE_MOMENTS,
    GROWTH,
    HORIZON,
    INSTANT,
    INVERSE_MASS,
    INVERSE_MOMENTS,
    LARGEST,
    LATEST,
    LOOKS,
    MET_SINCE,
    MET_TIME,
    MOMENTUM,
    NEXT_EPOCH,
    NOW,
    REACH_SIZE,
    REFINE,
    SINCE,
    SIZE,
    SPARED,
    TIME,
    VECTORS,
    VELOCITY,
    VIRIAL,
    WATCHED,
)
from edmd.tolerances import (
    DRIFTED,
    EPOCH_COLLISIONS,
    EPOCH_LEAST,
    EPOCH_LENGTHS,
    EPOCH_LOOKS,
    GROWTH_HORIZON,
    HORIZON_FREE_TIMES,
    HORIZON_OFF,
    INSTANT_SHARE,
    REFINE_BELOW,
)
from edmd.watching import watch


@kernel
def start_epoch(world):
    """Count every time, and every sum, from now on. The mean free time of the epoch that ends decides when planes are renewed."""
    clock, tally, n = world.clock, world.tally, len(world.bodies)
    now, collisions = clock[NOW], tally[COLLISIONS] - tally[EPOCH_BEGAN]
    collisions -= tally[SPARED] - tally[EPOCH_SPARED]
    missing = 0 if tally[LOOKS] >= tally[ENOUGH] else max(tally[NEXT_EPOCH] - tally[COLLISIONS], 0)
    free_time = _free_time(now * n / 2.0, collisions, missing, clock)
    _close_the_books(world)
    tally[EPOCH_BEGAN], tally[EPOCH_SPARED] = tally[COLLISIONS], tally[SPARED]
    tally[NEXT_EPOCH] = tally[COLLISIONS] + max(EPOCH_COLLISIONS * n, EPOCH_LEAST)
    tally[ENOUGH] = tally[LOOKS] + EPOCH_LOOKS * (tally[NEXT_EPOCH] - tally[COLLISIONS])
    clock[SIZE] = size_now(clock)
    clock[EPOCH] += now
    clock[NOW] = clock[ENERGY_SINCE] = clock[ENERGY_TIME] = clock[VIRIAL] = 0.0
    for body in range(n):
        world.bodies[body, TIME] -= now
        world.turns[body, MET_TIME] -= now
        world.turns[body, MET_SINCE] -= now
        world.lists.escapes[body, ESCAPE_TIME] -= now
        begin = int(world.lists.spans[body, BEGIN])
        for entry in range(begin, begin + int(world.lists.spans[body, COUNT])):
            world.lists.numbers[entry, EVENT] -= now
            world.lists.numbers[entry, SINCE] -= now
    for body in range(len(world.contacts.last)):
        world.contacts.last[body] -= now
    for place in range(len(world.calendar.time)):
        world.calendar.time[place] -= now
    if free_time > 0:
        _pace(world, free_time)


@kernel
def _free_time(spent, collisions, missing, clock):
    """The mean free time by an epoch; 0 where it cannot tell. Collisions that are missing count as was thought before: a few that come in
    a burst say little. spent: by pairs of bodies."""
    if collisions <= 0:
        return clock[NOW] if clock[NOW] > clock[HORIZON] else 0.0
    return (spent + missing * clock[REFINE] / REFINE_BELOW) / (collisions + missing)


@kernel
def _pace(world, free_time):
    """Let the mean free time decide when planes are renewed, and how far ahead bounds look: where that changes they are made anew."""
    clock = world.clock
    clock[REFINE] = REFINE_BELOW * free_time
    horizon = HORIZON_FREE_TIMES * free_time
    if clock[GROWTH] != 0.0:
        horizon = min(horizon, GROWTH_HORIZON * clock[SIZE] / abs(clock[GROWTH]))
    if not clock[HORIZON] < HORIZON_OFF * horizon < HORIZON_OFF**2 * clock[HORIZON]:
        clock[HORIZON] = horizon
        predict_all(world)


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
        of_body = 1 / world.kinds[kind_of(world, body)][INVERSE_MASS]
        mass += of_body
        momentum = add_scaled(momentum, of_body, load(world.bodies[body], VELOCITY))
    return mass, scale(1 / mass, momentum)


@kernel
def _take_back_drift(world):
    """Momentum is kept to the rounding of the fastest velocities there were. In a gas that cools by thirty decades that becomes a drift."""
    clock = world.clock
    mass, velocity = mean_velocity(world)
    drift = subtract(velocity, load(clock, DRIFT))
    if 0.5 * mass * dot(drift, drift) <= DRIFTED * clock[ENERGY]:
        return
    advance_all(world.bodies, world.turns, world.kinds, clock[NOW])
    for body in range(len(world.bodies)):
        store(world.bodies[body], VELOCITY, subtract(load(world.bodies[body], VELOCITY), drift))
    predict_all(world)


@kernel
def energy_counted(world):
    """What follows from a newly counted energy: the contact time in force, how long an epoch is at most, and an instant. Events of a
    collapsing gas crowd into less."""
    clock, longest = world.clock, 0.0
    mass, drift = mean_velocity(world)
    for kind in range(len(world.kinds)):
        longest = max(longest, world.kinds[kind, LARGEST] * size_now(clock))
    thermal_time = longest * sqrt(0.5 * mass / clock[ENERGY]) if clock[ENERGY] > 0 else 0.0
    clock[ENERGY_BEGAN] = clock[ENERGY]
    set_contact_time(world.contacts.rule, thermal_time)
    speed = sqrt(2 * clock[ENERGY] / mass + dot(drift, drift))
    clock[LATEST] = EPOCH_LENGTHS * longest / speed if speed > 0 else inf
    clock[INSTANT] = INSTANT_SHARE * thermal_time if world.contacts.rule[KIND] != ELASTIC and clock[GROWTH] == 0.0 else 0.0


@kernel
def active_momentum(row, kind):
    """The part of the angular momentum that collisions change: of smooth bodies of revolution the part across the axis."""
    momentum, axis = load(row, MOMENTUM), int(kind[AXIS])
    if kind[DEGREES] == 0:
        return (0.0, 0.0, 0.0)
    if kind[DEGREES] == 3:
        return momentum
    along = load(row, VECTORS + 3 * axis)
    return add_scaled(momentum, -dot(momentum, along) / dot(along, along), along)


@kernel
def kinetic_energy(world):
    """Energy of all motions that collisions exchange: not that of the common drift, nor of the spin of smooth bodies of revolution."""
    energy = 0.0
    _, drift = mean_velocity(world)
    for body in range(len(world.bodies)):
        row, kind = world.bodies[body], world.kinds[kind_of(world, body)]
        velocity, active = subtract(load(row, VELOCITY), drift), active_momentum(row, kind)
        energy += 0.5 * (dot(velocity, velocity) / kind[INVERSE_MASS] + dot(active, turning(row, kind, active)))
    return energy


@kernel
def rescale(world, factor, inertia_factor):
    """Multiply the exchanged velocities by a factor; moments of inertia by another, at unchanged energy. Predictions are made anew.

    The spin of a body of revolution about its axis stays, whatever its moment.
    """
    clock = world.clock
    advance_all(world.bodies, world.turns, world.kinds, clock[NOW])
    store(clock, DRIFT, scale(factor, load(clock, DRIFT)))
    clock[HORIZON], clock[REFINE] = clock[HORIZON] / factor, clock[REFINE] / factor
    for body in range(len(world.bodies)):
        row = world.bodies[body]
        store(row, VELOCITY, scale(factor, load(row, VELOCITY)))
        active = active_momentum(row, world.kinds[kind_of(world, body)])
        spin = add_scaled(load(row, MOMENTUM), -1.0, active)
        store(row, MOMENTUM, add_scaled(scale(inertia_factor, spin), factor * sqrt(inertia_factor), active))
    for kind in range(len(world.kinds)):
        world.kinds[kind, ACROSS] /= inertia_factor
        for k in range(3):
            world.kinds[kind, INVERSE_MOMENTS + k] /= inertia_factor
            world.kinds[kind, FREE_MOMENTS + k] /= inertia_factor
    predict_all(world)


@kernel
def set_velocities(world, velocities, momenta):
    """New velocities (n, 3), which have no common drift, and angular momenta (n, 3) but for the spin that smooth bodies never change."""
    advance_all(world.bodies, world.turns, world.kinds, world.clock[NOW])
    store(world.clock, DRIFT, (0.0, 0.0, 0.0))
    for body in range(len(world.bodies)):
        row, kind = world.bodies[body], world.kinds[kind_of(world, body)]
        store(row, VELOCITY, load(velocities[body], 0))
        spin = add_scaled(load(row, MOMENTUM), -1.0, active_momentum(row, kind))
        store(row, MOMENTUM, load(momenta[body], 0))
        store(row, MOMENTUM, add_scaled(spin, 1.0, active_momentum(row, kind)))
    predict_all(world)


@large_kernel
def predict_all(world):
    """Every prediction anew, for the velocities and the growth of now."""
    world.clock[ENERGY_TIME] += world.clock[ENERGY] * (world.clock[NOW] - world.clock[ENERGY_SINCE])
    world.clock[ENERGY_SINCE] = world.clock[NOW]
    world.clock[ENERGY] = kinetic_energy(world)
    energy_counted(world)
    advance_all(world.bodies, world.turns, world.kinds, world.clock[NOW])
    for body in range(len(world.bodies)):                           # pairs are watched before the turn of the second body comes
        set_turning(world.bodies[body], world.turns[body], world.kinds[kind_of(world, body)])
    for body in range(len(world.bodies)):
        world.tally[WATCHED] = 0
        predict(world, body)
        for k in range(world.tally[WATCHED]):
            watch(world, int(world.watched[k]), body)
        set_escapes(world, body, body)
    reschedule_all(world)


@kernel
def reschedule_all(world):
    for body in range(len(world.bodies)):
        reschedule(world, body)


@kernel
def forget_lists(world):
    """Empty every list."""
    world.clock[REACH_SIZE] = 0.0
    advance_all(world.bodies, world.turns, world.kinds, world.clock[NOW])
    for body in range(len(world.bodies)):
        world.lists.spans[body, COUNT] = 0
        world.anchors[body, ANCHOR_POSITION] = inf


@kernel
def make_lists(world):
    """The lists of all bodies that have none. -> DONE, or why it could not be: asked again, it goes on from there."""
    for body in range(len(world.bodies)):
        if world.anchors[body, ANCHOR_POSITION] == inf:
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
    if growth != 0:
        clock[HORIZON] = min(clock[HORIZON], GROWTH_HORIZON * size_now(clock) / abs(growth))
    forget_lists(world)
    status = make_lists(world)
    if status == DONE:
        predict_all(world)
    return status
