"""How long a body stays in its neighbourhood, eq. (6c), and that the neighbourhood lies ahead of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import edmd
from edmd.neighbors import staying
from edmd.state import ANCHOR_MARGIN, FASTEST, REBUILDS, SPREAD

UNIT = np.array([2.0, 3.0, 6.0]) / 7
BESIDE = np.array([6.0, 2.0, -3.0]) / 7


@settings(derandomize=True, deadline=None)
@given(share=st.floats(0, 1), across=st.floats(-1, 1), speed=st.floats(1e-3, 1e3), shrinking=st.floats(0, 1e3), room=st.floats(1e-3, 1e3))
def test_a_body_stays_until_its_path_fills_the_room(share, across, speed, shrinking, room):
    r, v = 0.999 * share * room * UNIT, speed * (across * UNIT + np.sqrt(1 - across * across) * BESIDE)

    def beyond(t):
        return np.linalg.norm(r + v * t) - (room - shrinking * t)
    left = brentq(beyond, 0.0, 1.001 * (room + np.linalg.norm(r)) / (speed + shrinking), xtol=1e-300, rtol=1e-14)
    assert abs(beyond(staying(tuple(r), tuple(v), room, shrinking))) <= 1e-9 * room
    assert staying(tuple(r), tuple(v), room, shrinking) == pytest.approx(left, rel=1e-6)


@pytest.mark.parametrize("r", [0.1, 0.3, 0.77])
@pytest.mark.parametrize("speed", [0.1, 0.7, 1e-9])
def test_at_the_middle_when_no_room_is_left(r, speed):
    """The quadratic has a double root, which rounding must not lose."""
    span = staying((r, 0.0, 0.0), (-speed, 0.0, 0.0), 1.1, 1.1 * speed / r)
    assert span == pytest.approx(r / speed, rel=1e-7)


def test_what_does_not_move_stays_and_what_is_outside_does_not():
    still = (0.0, 0.0, 0.0)
    assert staying((0.5, 0.0, 0.0), still, 1.0, 0.0) == np.inf
    assert staying((0.5, 0.0, 0.0), still, 1.0, 0.25) == 2.0
    assert staying((1.5, 0.0, 0.0), (-1.0, 0.0, 0.0), 1.0, 0.0) == 0.0
    assert staying((np.inf, 0.0, 0.0), still, 1.0, 0.0) == 0.0
    assert staying(still, (1.0, 0.0, 0.0), -0.1, 0.0) == 0.0


@pytest.mark.parametrize("semi_axes", [(1, 1, 1), (1, 1, 3), (2, 2, 0.5), (1, 1.25, 1.5625)])
def test_a_body_that_nobody_meets_crosses_the_whole_of_each_neighbourhood(semi_axes):
    """Two bodies side by side: a list lasts for the margin, and for nine tenths of it before, of what supports come."""
    rng = np.random.default_rng(5)
    system = edmd.System([[10, 10, 10], [40, 40, 40]], rng.normal(size=(2, 4)), semi_axes, 60.0,
                         velocities=[[0.3, 0.5, 0.2]] * 2, angular_velocities=[[0.1, 0.2, -0.1]] * 2)
    simulation = edmd.Simulation(system)
    world = simulation._world
    speed = np.sqrt(0.38) + world.turns[:, FASTEST] * world.kinds[0, SPREAD]
    time = 100 * world.anchors[:, ANCHOR_MARGIN] / speed
    before = world.tally[REBUILDS]
    simulation.run(time=time.max())
    lists = (time.max() / time * 100 / 1.9).sum()
    assert lists - 2 <= simulation._world.tally[REBUILDS] - before <= lists + 2
    simulation.verify()
