"""The bounds that make the shoot safe: nothing a body does in flight goes beyond them, and they are no looser than they say."""

import numpy as np
import pytest
from dense import Flights
from pairs import directions

from ccd.first_contact import grown, holding_time, support_motion

HORIZON = 0.8


def steady(semi_axes, spin):
    """What `support_motion` takes of a body that turns at a constant rate; the bounds are those of eqs. (7) and (7d)."""
    least, most, square = semi_axes.min(), semi_axes.max(), np.dot(spin, spin)
    bend = square * (most**2 - least**2)
    return spin, (0.0, 0.0, 0.0), 0.0, float(bend / least), 0.0, float(square * bend / 3)


@pytest.mark.parametrize("growth", [0.0, 1.0, -0.9])
@pytest.mark.parametrize("spin", [0.2, 1.0, 10.0])
@pytest.mark.parametrize("axes", [(0.9, 1.1), (0.1, 3)])
def test_the_support_of_a_flying_body_stays_below_its_parabola(axes, spin, growth):
    """Eqs. (5) to (7) and (11): it starts at the value and slope of h, and is nowhere below h up to the horizon."""
    rng, n = np.random.default_rng(1), 100
    body = Flights(np.exp(rng.uniform(*np.log(axes), (n, 3))), np.zeros((n, 3)), rng.normal(size=(n, 4)), np.zeros((n, 3)),
                   spin * directions(rng, n), np.full(n, growth))
    direction = directions(rng, n)

    def support(time):
        return np.linalg.norm(np.einsum("kij,ki->kj", body.at(np.full(n, time))[1], direction), axis=1)

    parabolas = []
    for k in range(n):
        s = tuple(map(tuple, body.pick([k]).at(np.zeros(1))[1][0].T.tolist()))
        turning = tuple(body.angular_velocity[k].tolist())
        ahead = steady(body.semi_axes[k], turning)
        parabolas.append(grown(support_motion(s, ahead, tuple(direction[k].tolist()), HORIZON), 1.0, growth, HORIZON))
    value, rate, bend = np.array(parabolas).T
    np.testing.assert_allclose(value, support(0.0), rtol=1e-14)
    np.testing.assert_allclose(rate, (support(1e-5) - support(-1e-5)) / 2e-5, rtol=0, atol=1e-7 * (1 + spin**3))
    for time in np.linspace(0, HORIZON, 81):
        assert (support(time) <= value + rate * time + 0.5 * bend * time**2 + 1e-13).all()


@pytest.mark.parametrize(("gap", "rate", "bend"), [(1, -1, 0), (1, -1, 2), (1, 1, 2), (1, 0, 2), (1e-12, -1, 5), (1e-12, 3, 5), (0, 1, 2)])
def test_the_holding_time_is_the_first_root_ahead(gap, rate, bend):
    time = holding_time(float(gap), float(rate), float(bend))
    assert time > 0
    assert gap + rate * time - 0.5 * bend * time**2 == pytest.approx(0, abs=1e-14)
    inside = np.linspace(0, time, 50)[1:-1]
    assert (gap + rate * inside - 0.5 * bend * inside**2 > 0).all()


def test_what_recedes_for_good_never_comes_back():
    assert holding_time(1.0, 0.5, 0.0) == holding_time(0.0, 0.5, 0.0) == np.inf
    assert holding_time(-1e-15, -1.0, 3.0) == 0
