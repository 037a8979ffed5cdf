"""Memory asked for ahead of time: that the right body is guessed, and that asking changes nothing."""

import numpy as np
import pytest

import edmd
from edmd import prefetch, state
from edmd.building import _calendar, flattened, with_room
from edmd.calendar import schedule
from edmd.engine import advance_events
from edmd.epoch import reschedule_all
from edmd.events import Ended, EventKind
from edmd.tolerances import FETCHED_AHEAD


def melted(n):
    return edmd.Simulation(edmd.random_system(n, (1, 1, 2), 0.4, seed=1)).run(collisions_per_particle=10)


@pytest.mark.parametrize("n", [1, 2, 8, 9, 64, 65, 600])
def test_the_next_body_has_the_second_event_of_all(n):
    """Of all but those that met its body before the last two matches."""
    rng, calendar = np.random.default_rng(n), _calendar(n)
    times = rng.choice([*rng.uniform(0, 1, n), np.inf], n)
    times[0] = 0.5
    for body in range(n):
        schedule(calendar, body, times[body])
    first = int(calendar.body[0])
    width = 8 ** max(len(calendar.rounds) - 3, 0)
    times[first // width * width:(first // width + 1) * width] = np.inf
    assert prefetch.likely_next(calendar, first) == (times.argmin() if np.isfinite(times).any() else first)


def test_it_is_nearly_always_the_next():
    world, events = melted(60)._world, 500
    calendar, right = world.calendar, 0
    for _ in range(events):
        guess = prefetch.likely_next(calendar, int(calendar.body[0]))
        world, status = with_room(world, advance_events, calendar.time[0], 2**62)
        assert status == Ended.TIME
        right += guess == calendar.body[0]
    assert right > 0.7 * events                 # 60 bodies: an event in between is not rare


def test_it_is_known_whom_a_body_awaits():
    """The partner of the earliest entry of its list, or itself for its escape."""
    world = melted(60)._world
    reschedule_all(world)
    spans, seen = world.lists.spans, set()
    for body, span in enumerate(spans[:-1]):
        slot = span[state.SLOT]
        awaited = body if slot == EventKind.ESCAPE else world.lists.links[span[state.BEGIN] + slot, state.PARTNER]
        assert span[state.AWAITED] == awaited
        seen.add(slot == EventKind.ESCAPE)
    assert seen == {True, False}


@pytest.mark.parametrize("compiled", [True, False])
def test_asking_changes_nothing(compiled):
    world = melted(60)._world
    before = {name: array.copy() for name, array in flattened(world)}
    for body in range(60):
        for ask in (prefetch.fetch_next, prefetch.fetch_event, prefetch.fetch_surroundings, prefetch.fetch_body):
            (ask if compiled else ask.py_func)(world, body)
        entry = int(world.lists.spans[body, state.BEGIN])
        partner = int(world.lists.links[entry, state.PARTNER])
        for ask, *rest in ((prefetch.fetch_pair, entry, body, partner), (prefetch.fetch_collision, body, partner, True)):
            (ask if compiled else ask.py_func)(world, *rest)
    for name, array in flattened(world):
        np.testing.assert_array_equal(array, before[name])


@pytest.mark.parametrize(("semi_axes", "rule"), [((1, 1, 1), "elastic"), ((1, 1, 2), "elastic"), ((1, 1.25, 1.5625), "elastic"),
                                                 ((1, 1, 2), edmd.Rough(0.9, 0.5))])
def test_a_large_system_of_copies_goes_as_the_small_one(semi_axes, rule):
    """Eight periodic copies of a system that is too small to ask ahead are large enough: each moves as the small one does, as long as
    rounding has not grown; the same bodies collide, eight times as often."""
    rng, edge, spacing = np.random.default_rng(1), 11, 2.4 * max(semi_axes)**0.5
    n, box = edge**3, edge * spacing * np.array([1, 1, max(semi_axes)**0.5])
    assert n < FETCHED_AHEAD <= 8 * n
    positions = (np.indices((edge,) * 3).reshape(3, n).T + 0.5) / edge * box
    orientations, motion = np.tile([1.0, 0, 0, 0], (n, 1)), rng.normal(size=(n, 6))
    shifts = np.indices((2, 2, 2)).reshape(3, 8).T * box
    ends = []
    for copies, cell, count in ((shifts[:1], box, 1), (shifts, 2 * box, 8)):
        system = edmd.System((copies[:, None] + positions).reshape(-1, 3), np.tile(orientations, (count, 1)), semi_axes, cell,
                             np.tile(motion[:, :3], (count, 1)), np.tile(motion[:, 3:], (count, 1)))
        ends.append(edmd.Simulation(system, rule=rule).run(time=1.0))
    small, large = ends
    assert small.collisions > n / 4
    assert large.collisions == 8 * small.collisions
    moved = large.system.positions.reshape(8, n, 3) - shifts[:, None] - small.system.positions
    assert abs(moved - np.rint(moved / box) * box).max() < 1e-9
    turning, expected = large.system.angular_velocities.reshape(8, n, 3), small.system.angular_velocities
    assert abs(turning - expected).max() < 1e-9
