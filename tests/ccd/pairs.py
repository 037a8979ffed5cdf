"""Pairs of bodies for the tests of the collision detection, for the product and for the oracles."""

import numpy as np
from dense import Flights

import ccd


def directions(rng, n):
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def meeting(rng, n, axes=(0.15, 3.0), spin=12.0, growth=0.0):
    """n pairs that come near each other in [0, 1]: semi-axes log-uniform, spins up to `spin` radians a window. About half of them touch."""
    def body(center, velocity):
        return Flights(np.exp(rng.uniform(*np.log(axes), (n, 3))), center, rng.normal(size=(n, 4)), velocity,
                       directions(rng, n) * rng.uniform(0, spin, (n, 1)), rng.uniform(-growth, growth, n))

    a = body(rng.normal(size=(n, 3)), rng.normal(size=(n, 3)))
    apart, miss = 6 * directions(rng, n), 1.2 * rng.normal(size=(n, 3))
    return a, body(a.center + apart, a.velocity + (miss - apart) * rng.uniform(0.5, 2, (n, 1)))


def joined(*flights):
    """One after another, as if they were one."""
    return Flights(*(np.concatenate([getattr(each, name) for each in flights]) for name in Flights.__dataclass_fields__))


def bodies(flights):
    """As the product takes them in a batch."""
    return ccd.Bodies(flights.semi_axes, flights.center, flights.orientation, flights.velocity, flights.angular_velocity,
                      flights.growth_rate)


def single(flights, k):
    """As the product takes one: (Ellipsoid, FreeFlight)."""
    return (ccd.Ellipsoid(flights.semi_axes[k], flights.center[k], flights.orientation[k]),
            ccd.FreeFlight(flights.velocity[k], flights.angular_velocity[k], flights.growth_rate[k]))


def assert_touches_there(contact, courses, k, on_surface, normal):
    """The k-th bodies of both courses (as `Flights`) are touched at the point of the contact, and their outward normals are its normal."""
    for course, sign in zip(courses, (1, -1)):
        center, axes = course.pick([k]).at(np.array([contact.time]))
        local = np.linalg.solve(axes[0], contact.point - center[0])
        assert abs(local @ local - 1) < on_surface
        outward = np.linalg.solve(axes[0].T, local)
        np.testing.assert_allclose(sign * outward / np.linalg.norm(outward), contact.normal, rtol=0, atol=normal)


def semi_axis_vectors(ellipsoid):
    """As the oracles take them: columns (3, 3)."""
    return ellipsoid.rotation_matrix * ellipsoid.semi_axes
