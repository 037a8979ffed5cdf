"""Memory asked for ahead of time: that the right body is guessed, and that asking changes nothing."""

import numpy as np
import pytest

import edmd
from edmd import prefetch
from edmd.building import _calendar, flattened, with_room
from edmd.calendar import schedule
from edmd.engine import advance_events
from edmd.events import Ended


def melted(n):
    return edmd.Simulation(edmd.random_system(n, (1, 1, 2), 0.4, seed=1)).run(collisions_per_particle=10)


@pytest.mark.parametrize("n", [1, 2, 8, 9, 64, 65, 600])
def test_the_next_body_has_the_second_event_of_all(n):
    """Of all but those that met its body before the last two matches."""
    rng, calendar = np.random.default_rng(n), _calendar(n)
    times = rng.choice([*rng.uniform(0, 1, n), np.inf], n)
    times[0] = 0.5
    for body in range(n):
        schedule(calendar, body, times[body], 0)
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


@pytest.mark.parametrize("compiled", [True, False])
def test_asking_changes_nothing(compiled):
    world = melted(60)._world
    before = {name: array.copy() for name, array in flattened(world)}
    for body in range(60):
        for ask in prefetch.fetch_next, prefetch.fetch_pair, prefetch.fetch_list_of_partner:
            (ask if compiled else ask.py_func)(world, body)
    for name, array in flattened(world):
        np.testing.assert_array_equal(array, before[name])
