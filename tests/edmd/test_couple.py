"""Two bodies side by side, of any kinds: seen, moved and told their bounds as each would be alone."""

import copy
import itertools

import numpy as np
import pytest

import edmd
from ccd.compiling import kernel
from ccd.lanes import first_of, second_of
from edmd.couple import arrive_both, flights_of, set_turning_of_both
from edmd.flight import advance, arrive, course, flight_of, kind_of, set_turning
from edmd.neighbors import set_escapes
from edmd.state import (
    ANCHOR_MARGIN,
    ESCAPE_TIME,
    FREE,
    GROWTH,
    HORIZON,
    KIND,
    MOTION,
    NOW,
    POSITION,
    STEADY,
    STILL,
    TIME,
    VECTORS,
    VELOCITY,
)

SHAPES = {"sphere": (0.8, 0.8, 0.8), "long": (0.5, 0.5, 1.4), "flat": (0.4, 1.1, 1.1), "free": (0.6, 0.9, 1.3),
          "isotropic": (0.7, 1.2, 0.9)}
KINDS = list(SHAPES)
PAIRS = list(itertools.product(range(len(KINDS)), repeat=2))


@pytest.fixture(scope="module", params=["all move", "some rest"])
def world(request):
    """One body of each kind, each up to date as of a time of its own."""
    axes = np.array(list(SHAPES.values()))
    squares = axes**2
    moments = (squares.sum(axis=1)[:, None] - squares) / 5
    moments[KINDS.index("isotropic")] = 0.3
    rng = np.random.default_rng(1)
    n = len(KINDS)
    q = rng.normal(size=(n, 4))
    velocities, spins = rng.normal(size=(n, 3)), 0.6 * rng.normal(size=(n, 3))
    if request.param == "some rest":
        velocities[::2], spins[::2] = 0.0, 0.0
    system = edmd.System(rng.uniform(2, 8, 3) + 5.0 * np.arange(n)[:, None], q / np.linalg.norm(q, axis=1)[:, None], axes, 40.0,
                         velocities, spins, inertia=moments)
    world = edmd.Simulation(system)._world
    for body in range(n):
        move(world, body, 0.01 * body)
    motions = world.kinds[world.bodies[:, KIND].astype(int), MOTION]
    assert motions.tolist() == [STILL, STEADY, STEADY, FREE, STEADY]
    return world


@kernel
def move(world, body, time):
    advance(world.bodies[body], world.turns[body], world.kinds[kind_of(world, body)], time)


@kernel
def seen(world, body, n):
    flight = flight_of(world, body)
    h, rate, second, third, fourth, bend = course(flight, n)
    return flight.position, flight.velocity, (h, rate, second), (third, fourth, bend)


@kernel
def seen_in_pair(world, body, partner, time, n):
    pair = flights_of(world, body, partner, time)
    x = course(pair, n)
    return ((first_of(pair.position), first_of(pair.velocity), first_of(x[:3]), first_of(x[3:])),
            (second_of(pair.position), second_of(pair.velocity), second_of(x[:3]), second_of(x[3:])))


@pytest.mark.parametrize("time", [0.0, 0.05, 0.9, 40.0])        # by series, and where those end
@pytest.mark.parametrize(("body", "partner"), PAIRS)
def test_a_pair_is_seen_as_each_body_alone(world, body, partner, time):
    n = tuple((np.array([2.0, -1.0, 2.0]) / 3).tolist())
    found = seen_in_pair(world, body, partner, time, n)
    for one, which in zip((body, partner), found):
        later = copy.deepcopy(world)
        move(later, one, time)
        np.testing.assert_allclose(which, seen(later, one, n), rtol=1e-12, atol=1e-13 * max(1.0, time))


@kernel
def arrived_alone(world, body):
    arrive(world.bodies[body], world.turns[body], world.kinds[kind_of(world, body)], world.clock[NOW])
    set_turning(world.bodies[body], world.turns[body], world.kinds[kind_of(world, body)])
    set_escapes(world, body, body)


@kernel
def arrived_together(world, body, partner):
    arrive_both(world, body, partner)
    set_turning_of_both(world, body, partner)
    set_escapes(world, body, partner)


@pytest.mark.parametrize(("time", "growth"), [(0.05, 0.0), (0.9, 0.01), (0.9, -0.01), (40.0, 0.0)])
@pytest.mark.parametrize(("body", "partner"), [pair for pair in PAIRS if pair[0] != pair[1]])
def test_a_pair_arrives_as_each_body_alone(world, body, partner, time, growth):
    """Poses, what is constant in flight and times of escape; of a sphere the pose stays, by which its orientation is told later."""
    together, alone = copy.deepcopy(world), copy.deepcopy(world)
    for each in (together, alone):
        each.clock[NOW], each.clock[GROWTH], each.clock[HORIZON] = time, growth, 2.0
        each.anchors[:, ANCHOR_MARGIN] = 1e3                # so that no body is out of its margin
    arrived_together(together, body, partner)
    arrived_alone(alone, body)
    arrived_alone(alone, partner)
    for one in (body, partner):
        np.testing.assert_allclose(together.bodies[one], alone.bodies[one], rtol=1e-12, atol=1e-13 * max(1.0, time))
        np.testing.assert_allclose(together.turns[one], alone.turns[one], rtol=1e-11, atol=1e-12)
        assert together.lists.escapes[one, ESCAPE_TIME] == pytest.approx(alone.lists.escapes[one, ESCAPE_TIME], rel=1e-10)
        moves = world.bodies[one, VELOCITY:VELOCITY + 3].any() or growth != 0
        assert (time < together.lists.escapes[one, ESCAPE_TIME] < np.inf) == moves
        assert together.bodies[one, TIME] == time
    others = [one for one in range(len(KINDS)) if one not in (body, partner)]
    assert np.array_equal(together.bodies[others], world.bodies[others])


def test_a_sphere_keeps_its_pose(world):
    moved, sphere = copy.deepcopy(world), KINDS.index("sphere")
    moved.clock[NOW] = 1.0
    arrived_together(moved, sphere, KINDS.index("free"))
    assert np.array_equal(moved.bodies[sphere, VECTORS:], world.bodies[sphere, VECTORS:])
    gone = moved.bodies[sphere, POSITION:POSITION + 3] - world.bodies[sphere, POSITION:POSITION + 3]
    np.testing.assert_allclose(gone, world.bodies[sphere, VELOCITY:VELOCITY + 3], atol=1e-14)
