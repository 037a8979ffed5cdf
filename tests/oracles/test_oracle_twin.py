"""The twin is trusted because it knows the published two-body flights, and the billiard of spheres."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from reference import free_triaxial_omega
from scipy.spatial.transform import Rotation
from twin import Twin

FLIGHTS = json.loads(Path(__file__).with_name("collisions.json").read_text())


def solid(axes, mass):
    a, b, c = np.square(axes)
    return mass / 5 * np.array([b + c, a + c, a + b])


def state_of(flight, edge=64.0):
    return SimpleNamespace(
        positions=np.array([flight["x1"], flight["x2"]]), orientations=np.array([flight["q1"], flight["q2"]]), box=edge * np.eye(3),
        semi_axes=np.array([flight["axes1"], flight["axes2"]]), masses=np.array([flight["m1"], flight["m2"]]),
        moments=np.array([solid(flight["axes1"], flight["m1"]), solid(flight["axes2"], flight["m2"])]),
        velocities=np.array([flight["v1"], flight["v2"]]), angular_velocities=np.array([flight["w1"], flight["w2"]]))


@pytest.mark.parametrize("flight", FLIGHTS, ids=lambda flight: flight["name"])
def test_published_flight(flight):
    """Solid inertia of every shape, three different axes included."""
    twin = Twin(state_of(flight))
    found = twin.collisions(1, flight["horizon"])
    if flight["toi"] is None:
        assert found == []
        return
    assert found == [(pytest.approx(flight["toi"], abs=1e-10), 0, 1)]
    if flight["e"] == 1.0:
        assert twin.velocity == pytest.approx(np.array([flight["v1_after"], flight["v2_after"]]), abs=1e-8)
        assert twin.spin == pytest.approx(np.array([flight["w1_after"], flight["w2_after"]]), abs=1e-8)


def test_spheres_between_their_images():
    """A row of three spheres along a small cell, one moving: it hands its motion on, through the faces too."""
    start = SimpleNamespace(positions=np.array([[1.0, 2, 2], [4, 2, 2], [7, 2, 2]]), orientations=np.tile([1.0, 0, 0, 0], (3, 1)),
                            semi_axes=np.full((3, 3), 0.5), masses=np.ones(3), moments=np.full((3, 3), 0.1), box=np.diag([9.0, 9, 9]),
                            velocities=np.array([[1.0, 0, 0], [0, 0, 0], [0, 0, 0]]), angular_velocities=np.zeros((3, 3)))
    assert Twin(start).collisions(9, 11.0) == [(pytest.approx(time, rel=1e-12), *pair)
                                               for time, pair in [(2, (0, 1)), (4, (1, 2)), (8, (0, 2)), (10, (0, 1))]]


def test_a_body_with_three_moments_tumbles_as_jacobi_says():
    rng = np.random.default_rng(4)
    moments, spin = np.array([[1.0, 2.0, 3.3]]), rng.normal(size=3)
    frame = Rotation.random(random_state=5)
    twin = Twin(SimpleNamespace(positions=np.zeros((1, 3)), orientations=frame.as_quat(scalar_first=True)[None], semi_axes=np.ones((1, 3)),
                                masses=np.ones(1), moments=moments, box=9 * np.eye(3), velocities=np.zeros((1, 3)),
                                angular_velocities=frame.apply(spin)[None]))
    twin.until = 5.0
    twin._bring(0, 5.0)
    assert twin.frame[0].T @ twin.spin[0] == pytest.approx(free_triaxial_omega(moments[0], spin, 5.0), abs=1e-9)
    momentum = frame.apply(moments[0] * spin)
    assert twin.frame[0] @ (moments[0] * (twin.frame[0].T @ twin.spin[0])) == pytest.approx(momentum, abs=1e-10)
