"""Single flights with an independent answer (collisions.json, physics.md): contact time and outcome through edmd.Simulation."""

import json
from pathlib import Path

import independent
import numpy as np
import pytest
import reference

import edmd
from edmd.building import margin_lengths

FLIGHTS = json.loads((Path(__file__).parents[1] / "oracles" / "collisions.json").read_text())
EDGE = 64.0


def of_revolution(axes):
    return len(set(axes)) < 3


def turns_as_documented(flight):
    """The free rotation of a triaxial solid is not built; without rotation it does not matter before the contact."""
    return all(of_revolution(flight[f"axes{k}"]) or not np.any(flight[f"w{k}"]) for k in (1, 2))


KNOWN = [pytest.param(flight, id=flight["name"]) for flight in FLIGHTS if turns_as_documented(flight)]


def simulated(flight):
    centre = np.full(3, EDGE / 2)
    return edmd.Simulation(edmd.System(np.array([flight["x1"], flight["x2"]]) + centre, [flight["q1"], flight["q2"]],
                                       [flight["axes1"], flight["axes2"]], EDGE, [flight["v1"], flight["v2"]],
                                       [flight["w1"], flight["w2"]], masses=[flight["m1"], flight["m2"]]), restitution=flight["e"])


def test_most_flights_are_used():
    assert len(KNOWN) >= 16
    assert any(flight.values[0]["toi"] is None for flight in KNOWN)
    assert {flight.values[0]["e"] for flight in KNOWN} == {0.8, 1.0}


@pytest.mark.parametrize("flight", KNOWN)
def test_flight(flight):
    simulation = simulated(flight)
    if flight["toi"] is None:
        simulation.run(time=flight["horizon"])
        assert simulation.collisions == 0
        return
    simulation.run(collisions=1)
    assert simulation.time == pytest.approx(flight["toi"], abs=1e-9)
    after = simulation.system

    masses, axes = (flight["m1"], flight["m2"]), np.array([flight["axes1"], flight["axes2"]])
    moments = independent.solid_moments(axes, masses)
    x1, x2 = (np.add(flight[f"x{k}"], np.multiply(flight["toi"], flight[f"v{k}"])) for k in (1, 2))
    point, turned = np.array(flight["contact_from1"]), [reference.quat_to_R(np.array(flight[f"q{k}_at"])) for k in (1, 2)]
    v1, w1, v2, w2, _ = reference.collide(masses[0], moments[0], turned[0], np.array(flight["v1"]), np.array(flight["w1_at"]), point,
                                          masses[1], moments[1], turned[1], np.array(flight["v2"]), np.array(flight["w2_at"]),
                                          x1 + point - x2, np.array(flight["normal"]), e=flight["e"])
    assert after.velocities == pytest.approx(np.array([v1, v2]), abs=1e-8)
    assert after.angular_velocities == pytest.approx(np.array([w1, w2]), abs=1e-7)
    if all(map(of_revolution, axes.tolist())):
        assert after.velocities == pytest.approx(np.array([flight["v1_after"], flight["v2_after"]]), abs=1e-8)
        assert after.angular_velocities == pytest.approx(np.array([flight["w1_after"], flight["w2_after"]]), abs=1e-7)
    assert independent.shape_matrices(after.orientations, axes) == pytest.approx(
        np.array([reference.shape_matrix(a, r) for a, r in zip(axes, turned)]), abs=1e-8)


@pytest.mark.parametrize("time", [0.1, 3.7, 50.0])
@pytest.mark.parametrize("axes", [(1, 1, 3.0), (1, 1, 0.2), (2.0, 0.5, 0.5)])
def test_free_precession_of_a_spheroid(axes, time):
    """A symmetric top without contacts, against the exact solution: axis and angular velocity precess about L at |L| / I_perp."""
    rng = np.random.default_rng(2)
    q, w = rng.normal(size=(2, 4)), rng.normal(size=(2, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    system = edmd.System([[10, 10, 10], [40, 40, 40]], q, axes, EDGE, angular_velocities=w, masses=[1.0, 3.0])
    after = edmd.Simulation(system).run(time=time).system
    along = next(k for k in range(3) if axes[(k + 1) % 3] == axes[(k + 2) % 3])
    moments = independent.solid_moments(np.array([axes, axes]), [1.0, 3.0])
    for k in range(2):
        u = independent.rotation_matrices(q)[k][:, along]
        u_exact, w_exact = reference.free_spheroid(moments[k, (along + 1) % 3], moments[k, along], u, w[k], time)
        assert independent.rotation_matrices(after.orientations)[k][:, along] == pytest.approx(u_exact, abs=1e-11)
        assert after.angular_velocities[k] == pytest.approx(w_exact, abs=1e-11)


@pytest.mark.parametrize("axes", [(1, 1, 3.0), (2.0, 0.5, 0.5)])
def test_the_whole_frame_of_a_spheroid_turns(axes):
    """Not the axis alone: the orientation against an integration of dR/dt = w x R with Euler's equations."""
    from scipy.integrate import solve_ivp

    q, w = np.array([0.5, -0.1, 0.7, 0.3]), np.array([0.7, -1.3, 0.9])
    q /= np.linalg.norm(q)
    time = 4.2
    after = edmd.Simulation(edmd.System([[10, 10, 10]], [q], axes, EDGE, angular_velocities=[w])).run(time=time).system
    moments = independent.solid_moments(np.array([axes]), [1.0])[0]

    def motion(_, y):
        frame, spin = y[:9].reshape(3, 3), y[9:]         # spin in the body's frame
        return np.concatenate([np.cross(frame @ spin, frame.T).T.ravel(), -np.cross(spin, moments * spin) / moments])

    frame = independent.rotation_matrices([q])[0]
    end = solve_ivp(motion, (0, time), np.concatenate([frame.ravel(), frame.T @ w]), rtol=1e-12, atol=1e-13, method="DOP853").y[:, -1]
    assert independent.rotation_matrices(after.orientations)[0] == pytest.approx(end[:9].reshape(3, 3), abs=1e-9)


def test_head_on_through_the_faces_of_the_cell():
    """Spheres that meet across a face of the cell: the nearest image collides."""
    system = edmd.System([[1.5, 5, 5], [8.0, 5, 5]], [[1, 0, 0, 0]] * 2, (0.5, 0.5, 0.5), 10.0, velocities=[[-1, 0, 0], [1.0, 0, 0]])
    simulation = edmd.Simulation(system).run(collisions=1)
    assert simulation.time == pytest.approx(1.25, abs=1e-14)
    assert simulation.system.velocities == pytest.approx(np.array([[1, 0, 0], [-1.0, 0, 0]]), abs=1e-14)


@pytest.mark.parametrize("below", [1e-6, 1e-9])
def test_grazing_spheres(below):
    """Impact parameter below and above the sum of the radii: a collision with next to no impulse, and none."""
    for factor, collisions in ((1 - below, 1), (1 + below, 0)):
        system = edmd.System([[10, 10, 10], [20, 10 + factor, 10]], [[1, 0, 0, 0]] * 2, (0.5, 0.5, 0.5), 40.0,
                             velocities=[[1, 0, 0], [-1.0, 0, 0]])
        simulation = edmd.Simulation(system).run(time=8.0)
        assert simulation.collisions == collisions
        if collisions:
            assert simulation.system.velocities[0, 1] == pytest.approx(-2 * np.sqrt(2 * below), rel=1e-3)


def first_contact_of_parallel_bodies(r, v, semi_axes, edge, longest):
    """Two equal parallel ellipsoids that do not turn are spheres of radius 1 in coordinates scaled by their semi-axes. By numpy, of all
    images. inf for none within the longest time."""
    across = int(np.ceil(np.linalg.norm(v) * longest / edge)) + 2
    images = np.stack(np.meshgrid(*[np.arange(-across, across + 1)] * 3), axis=-1).reshape(-1, 3)
    r, v = (r + edge * images) / semi_axes, v / semi_axes
    closing, square = r @ v, (r * r).sum(axis=1) - 4
    root = closing**2 - (v @ v) * square
    times = (-closing - np.sqrt(np.maximum(root, 0))) / (v @ v)
    times = times[(root > 0) & (closing < 0)]
    return times.min() if len(times) and times.min() < longest else np.inf


def test_bodies_that_pass_each_other_meet_in_another_image():
    """Nearly round bodies that do not turn: the plane between them holds for ever, while they come near each other elsewhere."""
    rng, semi_axes, edge, met = np.random.default_rng(5), np.array([1, 1, 1.002]), 8.0, []
    for _ in range(60):
        r, v = rng.uniform(2.1, edge - 2.1, size=3), rng.normal(size=3)
        expected = first_contact_of_parallel_bodies(r, v, semi_axes, edge, longest=60.0)
        met.append(expected)
        system = edmd.System([[1, 1, 1], r + 1], [[1, 0, 0, 0]] * 2, semi_axes, edge, velocities=[[0, 0, 0], v])
        simulation = edmd.Simulation(system)
        simulation.run(time=min(expected + 1e-9, 60.0))
        assert simulation.collisions == (expected < 60), (r, v, expected)
        simulation.verify()
    assert np.isfinite(met).sum() > 30


def thinnest_gas():
    """Two bodies that meet once in 1e5 lengths."""
    velocity = np.array([1.2, np.sqrt(1.7), -np.pi / 4])
    return edmd.Simulation(edmd.System([[10, 10, 10], [60, 50, 40]], [[1, 0, 0, 0], [0.5, 0.5, 0.5, 0.5]],
                                       [[0.5, 0.51, 2.4], [1.6, 1.6, 0.4]], 90.0, velocities=[velocity, -velocity]))


def test_times_keep_their_resolution_in_the_thinnest_gas():
    """Counted from the start, times of 1e5 would be known to 1e-11, and a body comes as far in that: `verify` finds that they overlap."""
    simulation = thinnest_gas()
    for _ in range(4):
        simulation.run(collisions=1)
        simulation.verify()
    assert simulation.time > 3e4
    assert simulation.begun.time < 15_000


def test_looking_between_its_collisions_changes_nothing():
    """An epoch that ends by its time ends there whoever looks."""
    unseen, seen, times = thinnest_gas().run(time=4e4), thinnest_gas(), []
    seen.run(time=4e4, observers=[edmd.Observer(edmd.Every(time=937.0), lambda view: times.append(view.time))])
    assert len(times) == 42
    assert independent.same_bits(seen.system, unseen.system)
    assert seen.begun.time == unseen.begun.time < 15_000


@pytest.mark.parametrize("wide", [1.01, 1.05, 1.09])
@pytest.mark.parametrize("axes", [(1, 1, 1), (1, 1, 1.3)])
def test_a_neighbour_comes_back_in_another_image(axes, wide):
    """A cell hardly wider than two lists: a neighbour that has just been dropped is found again on the other side."""
    radius = max(axes) + margin_lengths(np.array([axes]))[0]
    sites = np.stack(np.meshgrid(*[[0.25, 0.75]] * 3), axis=-1).reshape(-1, 3)[:7]
    edge = 4 * wide * radius
    simulation = edmd.Simulation(edmd.thermalized(edmd.System(edge * sites, [[1, 0, 0, 0]] * 7, axes, edge), seed=1))
    for _ in range(150):
        simulation.run(collisions=1)
        simulation.verify()
