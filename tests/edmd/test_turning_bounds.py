"""What the engine takes of how a shape will turn is a bound on how it does: eqs. (7d) and (7e), against dense sampling in time."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import edmd
from edmd.flight import course, flight_of
from edmd.pairs import support_until
from edmd.state import BEND, EVENTS, FASTEST, GENERAL, KIND, POLE, SPREAD

TIMES = np.linspace(0, 8.0, 4001)           # of a body that turns once a radian


def turning_body(semi_axes, tilt, rate=1.0):
    """World of a body of revolution whose shape turns at this rate about a direction at this angle from its axis; its axis, and that."""
    axis = next(k for k in range(3) if semi_axes[k - 1] == semi_axes[k - 2])
    u = np.eye(3)[axis]
    about = np.cos(tilt) * u + np.sin(tilt) * np.eye(3)[axis - 1]
    body = edmd.System([[9.0, 9, 9]], [[1, 0, 0, 0]], semi_axes, 20.0)
    across, along = body.moments[0, axis - 1], body.moments[0, axis]
    spin = rate * (about + (across / along - 1) * (about @ u) * u)                  # so that L / I_perp = rate * about
    body.angular_velocities[:] = spin
    return edmd.Simulation(body)._world, u, about


def supports(semi_axes, u, about, n, rate=1.0):
    """h(n) (directions, times), by turning the body."""
    seen = n @ Rotation.from_rotvec(rate * TIMES[:, None] * about).as_matrix()              # in the frame of the body
    return np.linalg.norm(seen * np.array(semi_axes), axis=2).T


SHAPES = [(1, 1, 2.0), (3, 0.5, 0.5), (1, 0.4, 1), (1, 1, 0.1), (1, 1, 1.05)]
TILTS = [0.0, 1e-9, 1e-4, 0.03, 0.4, np.pi / 4, 1.2, np.pi / 2, 2.8, np.pi]


@pytest.mark.parametrize("by", ["axis", "semi-axis vectors"])
@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("semi_axes", SHAPES)
def test_a_support_stays_below_its_parabola(semi_axes, tilt, by):
    """Up to a short and to a long reach: the local bound of the third order, and the one for all time."""
    world, u, about = turning_body(semi_axes, tilt)
    if by != "axis":
        world.kinds[:, POLE] = GENERAL
    flight = flight_of(world, 0)
    assert flight.axial == (by == "axis")
    n = np.random.default_rng(4).normal(size=(40, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    h = supports(semi_axes, u, about, n)
    for reach in (0.05, 0.5, 8.0):
        within = reach >= TIMES
        for k, direction in enumerate(n):
            value, rate, bend = support_until(course(flight, tuple(direction.tolist())), 1.0, 0.0, reach)
            time = TIMES[within]
            assert (h[k, within] <= value + rate * time + 0.5 * bend * time**2 + 1e-13).all()


@pytest.mark.parametrize("tilt", TILTS[3:8])
@pytest.mark.parametrize("semi_axes", SHAPES)
def test_the_bound_for_all_time_is_that_of_eq_7e(semi_axes, tilt):
    """The largest second derivative of h^2 / 2 over all directions is the one of a matrix; the bound is it, or of prolate bodies more."""
    world, u, about = turning_body(semi_axes, tilt)
    a2 = np.array(semi_axes)**2
    w = np.array([[0, -about[2], about[1]], [about[2], 0, -about[0]], [-about[1], about[0], 0]])
    turned = w @ np.diag(a2) - np.diag(a2) @ w
    most = np.linalg.eigvalsh(w @ turned - turned @ w)[-1] / 2
    bound = world.turns[0, BEND] * min(semi_axes)
    assert bound >= most * (1 - 1e-12)
    s = np.sin(tilt)
    if abs(u) @ semi_axes < max(semi_axes):
        assert bound == pytest.approx(most, rel=1e-9)
    assert bound == pytest.approx(0.5 * s * (1 + s) * (a2.max() - a2.min()), rel=1e-9)


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("semi_axes", SHAPES)
def test_no_support_changes_faster_than_the_axis_moves(semi_axes, tilt):
    """Eq. (6) with the speed of the axis in place of the whole turning."""
    world, u, about = turning_body(semi_axes, tilt)
    turn, kind = world.turns[0], world.kinds[int(world.bodies[0, KIND])]
    n = np.random.default_rng(5).normal(size=(200, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    h = supports(semi_axes, u, about, n)
    assert turn[FASTEST] == pytest.approx(np.sin(tilt), abs=1e-15)
    assert (abs(np.diff(h, axis=1)) <= turn[FASTEST] * kind[SPREAD] * TIMES[1] + 1e-14).all()


def test_spin_about_the_axis_costs_no_looks():
    """A gas of spinning spheroids that has cooled by six decades: 75 events a collision where one without spin has 13. With the whole
    turning in the bounds they were 3100."""
    events = {}
    for spin in ("none", "drawn"):
        start = edmd.thermalized(edmd.random_system(32, (1, 1, 2.0), 0.2, seed=1), seed=1, spin=spin)
        simulation = edmd.Simulation(start, rule=edmd.Inelastic(restitution=0.6, contact_share=3e-3))
        while simulation.temperature > 1e-5:
            simulation.run(collisions_per_particle=5)
        before, collisions = simulation._world.tally[EVENTS], simulation.collisions
        simulation.run(collisions_per_particle=20)
        events[spin] = (simulation._world.tally[EVENTS] - before) / (simulation.collisions - collisions)
    assert events["drawn"] < 15 * events["none"]
