"""The free rotation of solids of revolution as a flight: against Euler's equations, integrated by scipy."""

import numpy as np
import pytest
from pairs import directions
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import ccd
from ccd import Ellipsoid, FreeFlight, Status


def solid_in_flight(semi_axes, orientation, angular_velocity, time):
    """Shape matrices (n, 3, 3) of a torque-free solid at the times (n,): I w' = (I w) x w in the body, q' = q w / 2."""
    squares = np.array(semi_axes) ** 2
    moments = squares.sum() - squares

    def rates(_, state):
        w, q = state[:3], state[3:]
        return np.concatenate([np.cross(moments * w, w) / moments,
                               0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])])

    turned = Rotation.from_quat(np.roll(orientation, -1))
    start = np.concatenate([turned.inv().apply(angular_velocity), np.roll(turned.as_quat(), 1)])
    states = solve_ivp(rates, (0, time[-1]), start, t_eval=time, method="DOP853", rtol=1e-12, atol=1e-13).y
    axes = Rotation.from_quat(np.roll(states[3:], -1, axis=0).T).as_matrix() * semi_axes
    return axes @ axes.transpose(0, 2, 1)


@pytest.mark.parametrize("semi_axes", [(1, 1, 3), (3, 1, 1), (2, 0.4, 2), (1, 1, 0.01), (1.5, 1.5, 1.5)])
def test_the_surface_of_a_free_solid_of_revolution_moves_as_its_flight(semi_axes):
    rng, time = np.random.default_rng(1), np.linspace(0, 2, 41)
    for spin in 5 * directions(rng, 4):
        solid = Ellipsoid(semi_axes, orientation=rng.normal(size=4))
        flight = FreeFlight.of_solid(solid, (0, 0, 0), spin)
        axes = Rotation.from_rotvec(time[:, None] * flight.angular_velocity).as_matrix() @ (solid.rotation_matrix * solid.semi_axes)
        np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), solid_in_flight(semi_axes, solid.orientation, spin, time),
                                   rtol=0, atol=2e-10 * max(semi_axes) ** 2)


def test_the_rest_of_the_flight_is_as_given():
    flight = FreeFlight.of_solid(Ellipsoid((1, 1, 2)), (1, 2, 3), (0, 0, 4), growth_rate=0.5)
    assert (flight.velocity.tolist(), flight.growth_rate) == ([1, 2, 3], 0.5)
    np.testing.assert_allclose(flight.angular_velocity, (0, 0, 4 * 2 / 5), rtol=1e-15)      # I_par / I_perp = 2 / (1 + 2^2)
    assert not FreeFlight.of_solid(Ellipsoid((2, 2, 2)), (0, 0, 0), (1, 2, 3)).angular_velocity.any()


def test_a_precessing_needle_hits_where_the_solid_does():
    """A slow wall of a sphere comes up to a needle whose axis goes round on a cone: it touches when Euler's needle does."""
    needle, spin = Ellipsoid((0.2, 0.2, 2), orientation=(1, 0.3, 0, 0)), np.array([1.0, 2.0, 6.0])
    far = 1e4
    found = ccd.first_contact(needle, FreeFlight.of_solid(needle, (0, 0, 0), spin), Ellipsoid([far] * 3, (0, 2.4 + far, 0)),
                              FreeFlight((0, -0.8, 0)), (0, 2.5))
    assert found.status == Status.CONTACT
    time = np.linspace(0, 2.5, 20001)
    reach = np.sqrt(solid_in_flight((0.2, 0.2, 2), needle.orientation, spin, time)[:, 1, 1])     # support along y
    first = (reach > 2.4 - 0.8 * time).argmax()
    assert found.time == pytest.approx(time[first], abs=3e-4)       # flat to 2^2 / 2 far, seen every 1.25e-4


def test_a_solid_with_three_different_axes_turns_freely_with_its_moments():
    flight = FreeFlight.of_solid(Ellipsoid((1, 2, 3)), (0, 0, 0), (0, 0, 1))
    assert flight.angular_velocity.tolist() == [0, 0, 1]
    np.testing.assert_allclose(flight.moments / flight.moments[2], (13 / 5, 10 / 5, 1), rtol=1e-15)
    assert FreeFlight.of_solid(Ellipsoid((1, 2, 3)), (1, 0, 0)).moments is None
    assert FreeFlight.of_solid(Ellipsoid((1, 1, 3)), (1, 0, 0), (0, 0, 1)).moments is None


def test_what_is_no_solid_in_flight_is_refused():
    with pytest.raises(ValueError, match=r"angular_velocity.*finite"):
        FreeFlight.of_solid(Ellipsoid((1, 1, 3)), (0, 0, 0), (0, 0, np.nan))
    with pytest.raises(ValueError, match=r"expected a ccd\.Ellipsoid"):
        FreeFlight.of_solid((1, 1, 3), (0, 0, 0))
