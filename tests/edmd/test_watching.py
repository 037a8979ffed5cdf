"""Planes aimed at the contact (theory (8d)): that the aim is right, and that a plane that cuts into the bodies is never believed."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import ccd
import edmd
from ccd.compiling import kernel
from ccd.lanes import abreast, two
from edmd.flight import Flight
from edmd.watching import tilted


def flight(body, velocity, spin):
    """A flight as the engine has it, of a steadily turning body."""
    vectors = tuple(tuple(v) for v in body.semi_axis_vectors.T)
    return Flight(tuple(body.center), tuple(velocity), False, vectors, (tuple(spin), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 1.0))


@kernel
def tilted_pair(a, b, r, n, scales):
    vectors = abreast(a.vectors[0], b.vectors[0]), abreast(a.vectors[1], b.vectors[1]), abreast(a.vectors[2], b.vectors[2])
    none = two(0.0, 0.0)
    turning = abreast(a.turning[0], b.turning[0]), abreast(a.turning[1], b.turning[1]), none, none, none, none
    return tilted(Flight(abreast(a.position, b.position), abreast(a.velocity, b.velocity), False, vectors, turning), r, n, scales)


def moved(body, velocity, spin, time):
    turn = Rotation.from_rotvec(np.multiply(spin, time)) * Rotation.from_quat(body.orientation, scalar_first=True)
    return ccd.Ellipsoid(body.semi_axes, body.center + np.multiply(velocity, time), turn.as_quat(scalar_first=True))


@settings(derandomize=True, max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
def test_the_aim_is_the_best_direction_at_the_contact(seed):
    """Of bodies that are about to meet: but for terms of second order in the angles by which they turn until then."""
    rng = np.random.default_rng(seed)
    axes = [rng.uniform(0.5, 1.5, 3) for _ in range(2)]
    turns = [rng.normal(size=4) for _ in range(2)]
    touching = ccd.separation(ccd.Ellipsoid(axes[0], (0, 0, 0), turns[0]), ccd.Ellipsoid(axes[1], (4.0, 0, 0), turns[1]))
    apart = 4.0 / np.sqrt(touching.contact_function)
    a, b = ccd.Ellipsoid(axes[0], (0, 0, 0), turns[0]), ccd.Ellipsoid(axes[1], (apart, 0, 0), turns[1])
    n = ccd.separation(a, b).normal
    spins, velocity = [rng.uniform(-1, 1, 3) for _ in range(2)], rng.uniform(-0.3, 0.3, 3) - n
    span = 0.01                                                                     # back in time, from near a contact
    a, b = moved(a, (0, 0, 0), spins[0], -span), moved(b, velocity, spins[1], -span)
    found = ccd.first_contact(a, ccd.FreeFlight((0, 0, 0), spins[0]), b, ccd.FreeFlight(velocity, spins[1]), (0.0, 10 * span))
    now = ccd.separation(a, b)
    assume(found.status == ccd.Status.CONTACT and now.gap > 0.2 * span)         # or surfaces turn away as fast as the bodies approach
    direction, _, lead, gap = tilted_pair(flight(a, (0, 0, 0), spins[0]), flight(b, velocity, spins[1]), tuple(b.center - a.center),
                                          tuple(now.normal), (1.0, 0.0, 1.0, 0.0))
    best = ccd.separation(moved(a, (0, 0, 0), spins[0], found.time), moved(b, velocity, spins[1], found.time)).normal
    turned = np.linalg.norm(best - now.normal)                                      # small by chance where the two turn it to and fro
    angle = found.time * max(np.linalg.norm(spins[0]), np.linalg.norm(spins[1]))
    assert gap > 0
    assert lead == pytest.approx(found.time, rel=0.2)
    assert np.linalg.norm(direction - best) <= 0.25 * (turned + angle**2)


@pytest.mark.parametrize("semi_axes", [(1.0, 1.0, 10.0), (5.0, 5.0, 1.0), (1.0, 1.5, 6.0)])
def test_long_and_flat_bodies_far_apart(semi_axes):
    """Their gaps are far from parabolas: planes aimed too far cut into the bodies, and were once believed."""
    simulation = edmd.Simulation(edmd.random_system(40, semi_axes, 0.02, seed=1))
    for _ in range(10):
        simulation.run(collisions=20)
        simulation.verify()
