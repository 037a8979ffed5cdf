import MDAnalysis as mda
import numpy as np
import pytest
from runs import random_quaternions, write_run
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import analysis


def random_axes(rng, n):
    axes = rng.normal(size=(n, 3))
    return axes / np.linalg.norm(axes, axis=1)[:, None]


def test_parallel_axes_have_order_one_along_themselves():
    axis = np.array([2.0, -6.0, 3.0]) / 7
    signs = np.array([1, -1, -1, 1, 1])[:, None]
    order, director = analysis.nematic_order(signs * axis)
    assert order == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(director, -axis, atol=1e-14)  # the component of largest magnitude is positive


def test_three_perpendicular_axes_have_no_order():
    np.testing.assert_allclose(analysis.nematic_tensor(np.eye(3)), 0, atol=1e-15)


def test_axes_at_random_in_a_plane_have_a_quarter():
    angles = np.arange(360) * np.pi / 180
    axes = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    np.testing.assert_allclose(np.linalg.eigvalsh(analysis.nematic_tensor(axes)), [-0.5, 0.25, 0.25], atol=1e-14)
    assert analysis.nematic_order(axes)[0] == pytest.approx(0.25, abs=1e-14)


def test_a_cone_has_the_second_legendre_polynomial():
    turn = np.arange(60) * 2 * np.pi / 60
    tilt = 0.4
    axes = np.column_stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.full(60, np.cos(tilt))])
    order, director = analysis.nematic_order(axes)
    assert order == pytest.approx(1.5 * np.cos(tilt) ** 2 - 0.5, abs=1e-14)
    np.testing.assert_allclose(director, [0, 0, 1], atol=1e-14)


def test_random_axes_have_order_of_one_over_root_n():
    rng = np.random.default_rng(11)
    n, runs = 400, 50
    orders = np.array([analysis.nematic_order(random_axes(rng, n))[0] for _ in range(runs)])
    # <tr Q^2> = 3/(2 n), and tr Q^2 lies between 3/2 and 2 times S^2 up to a factor of order one: S is within (1/2, 1) / sqrt(n)
    assert 0.5 / np.sqrt(n) < orders.mean() < 1.0 / np.sqrt(n)
    squares = [np.sum(analysis.nematic_tensor(random_axes(rng, n)) ** 2) for _ in range(runs)]
    # tr Q^2 is 3/(10 n) times a chi-square of five degrees of freedom: relative deviation sqrt(2/5), here four of them
    assert np.mean(squares) == pytest.approx(1.5 / n, rel=4 * np.sqrt(0.4 / runs))


def test_the_tensor_turns_with_the_axes():
    rng = np.random.default_rng(5)
    axes, turn = random_axes(rng, 30), Rotation.random(random_state=2).as_matrix()
    np.testing.assert_allclose(analysis.nematic_tensor(axes @ turn.T), turn @ analysis.nematic_tensor(axes) @ turn.T, atol=1e-14)


@pytest.mark.parametrize(("semi_axes", "column"), [((1, 1, 3), 2), ((2, 0.5, 0.5), 0), ((0.5, 2, 0.5), 1), ((1, 1, 0.3), 2),
                                                   ((0.3, 1, 1), 0), ((1, 3, 2), 1), ((3, 2, 1), 0), ((1, 1, 1), 2)])
def test_body_axes_are_the_field_s(semi_axes, column):
    q = random_quaternions(np.random.default_rng(8), 6)
    matrices = Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_matrix()
    np.testing.assert_allclose(analysis.body_axes(q, np.tile(semi_axes, (6, 1))), matrices[:, :, column], atol=1e-14)


def test_along_a_trajectory(tmp_path):
    q = np.tile([1.0, 0, 0, 0], (3, 9, 1))
    q[1] = [np.sqrt(0.5), 0, np.sqrt(0.5), 0]  # z to x
    q[2] = random_quaternions(np.random.default_rng(1), 9)
    path = write_run(tmp_path / "run.h5md", np.random.default_rng(0).random((9, 3)), q, (1, 1, 2), np.eye(3) * 9, [0, 1, 2])
    universe = mda.Universe(path)
    results = analysis.NematicOrder(universe.atoms).run().results
    np.testing.assert_allclose(results.order[:2], 1.0, atol=1e-14)
    np.testing.assert_allclose(results.director[:2], [[0, 0, 1], [1, 0, 0]], atol=1e-14)
    assert results.order[2] < 0.9


@pytest.mark.parametrize("axes", [np.zeros((0, 3)), np.ones((4, 2)), np.ones(3), [[1.0, 1.0, 0.0]], [[np.nan, 0.0, 0.0]]])
def test_what_is_not_unit_vectors_is_refused(axes):
    with pytest.raises(ValueError, match="axes"):
        analysis.nematic_tensor(axes)


def test_shapes_that_disagree_are_refused():
    with pytest.raises(ValueError, match="semi_axes"):
        analysis.body_axes(np.ones((3, 4)) / 2, np.ones((2, 3)))
    with pytest.raises(ValueError, match="orientations"):
        analysis.body_axes(np.ones((3, 3)), np.ones((3, 3)))


# biaxial order

def quaternions_of(rotation):
    return rotation.as_quat()[:, [3, 0, 1, 2]]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_bodies_turned_by_plus_and_minus_an_angle_about_their_director(axis):
    """B is cos 2 alpha, by hand from the definition; the frame as a whole, and half turns of the bodies, mean nothing."""
    alpha = 0.3
    about = np.eye(3)[axis]
    frame = Rotation.random(random_state=4)
    half_turns = Rotation.from_rotvec(np.pi * np.eye(3))[np.arange(40) % 3]
    signs = np.where(np.arange(40) < 20, alpha, -alpha)
    q = quaternions_of(frame * Rotation.from_rotvec(signs[:, None] * about) * half_turns)
    uniaxial, biaxial, directors, found = analysis.biaxial_order(q)
    assert (uniaxial, biaxial, found) == (pytest.approx(1, abs=1e-13), pytest.approx(np.cos(2 * alpha), abs=1e-13), axis)
    lab = frame.as_matrix()
    others = [k for k in range(3) if k != axis]
    np.testing.assert_allclose(np.abs(directors @ lab), np.eye(3)[[*others, axis]], atol=1e-12)
    assert np.linalg.det(directors) == pytest.approx(1, abs=1e-12)


def test_bodies_that_spin_about_their_director_have_no_biaxial_order():
    spins = Rotation.from_rotvec(np.linspace(0, 2 * np.pi, 60, endpoint=False)[:, None] * [0, 0, 1])
    q = quaternions_of(Rotation.random(random_state=1) * spins)
    uniaxial, biaxial, _, axis = analysis.biaxial_order(q)
    assert (uniaxial, axis) == (pytest.approx(1, abs=1e-13), 2)
    assert biaxial == pytest.approx(0, abs=1e-13)


def test_no_choice_of_directions_has_more_biaxial_order():
    """The definition of Camp and Allen, searched over angles in the plane across the director."""
    q = random_quaternions(np.random.default_rng(3), 40)
    uniaxial, biaxial, directors, z = analysis.biaxial_order(q)
    bodies = Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_matrix()
    first, second = [1.5 * bodies[:, :, k].T @ bodies[:, :, k] / 40 - np.eye(3) / 2 for k in range(3) if k != z]
    x, y, _ = directors
    searched = []
    for angle in np.linspace(0, np.pi, 2001):
        a, b = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
        searched.append((a @ first @ a + b @ second @ b - a @ second @ a - b @ first @ b) / 3)
    assert searched[0] == pytest.approx(biaxial, abs=1e-13)
    assert max(searched) <= biaxial + 1e-13
    assert 0 < biaxial < 5 / np.sqrt(40)
    largest = max(np.linalg.eigvalsh(1.5 * bodies[:, :, k].T @ bodies[:, :, k] / 40 - np.eye(3) / 2)[-1] for k in range(3))
    assert uniaxial == pytest.approx(largest, abs=1e-14)


# cubatic order

def test_axes_along_three_directions_are_cubatic_and_not_nematic():
    frame = Rotation.random(random_state=6).as_matrix()
    axes = np.concatenate([frame, -frame, frame])
    order, directions = analysis.cubatic_order(axes)
    assert order == pytest.approx(1, abs=1e-12)
    np.testing.assert_allclose(np.sort(np.abs(directions @ frame.T)), [[0, 0, 1]] * 3, atol=1e-8)
    assert analysis.nematic_order(axes)[0] == pytest.approx(0, abs=1e-14)


def test_cubes_turned_by_quarter_turns_are_cubatic():
    frame, quarter = Rotation.random(random_state=7), Rotation.create_group("O")
    order, _ = analysis.cubatic_order(analysis.three_axes(quaternions_of(frame * quarter)))
    assert order == pytest.approx(1, abs=1e-12)


def test_cubes_turned_by_plus_and_minus_an_angle():
    """About one axis: sum of fourth powers 1 for it, cos^4 + sin^4 for the others, so C = 1 - 5/3 * 2 cos^2 sin^2."""
    alpha = 0.2
    q = quaternions_of(Rotation.random(random_state=8) * Rotation.from_rotvec(np.array([[0, 0, alpha], [0, 0, -alpha]] * 4)))
    expected = 1 - 10 / 3 * np.cos(alpha)**2 * np.sin(alpha)**2
    assert analysis.cubatic_order(analysis.three_axes(q))[0] == pytest.approx(expected, abs=1e-12)


def test_axes_spread_evenly_over_the_sphere_have_no_cubatic_order():
    """The vertices of an icosahedron: a spherical design of degree 5, to which fourth powers are constant."""
    golden = (1 + np.sqrt(5)) / 2
    vertices = np.array([[0, 1, golden], [0, 1, -golden], [1, golden, 0], [1, -golden, 0], [golden, 0, 1], [-golden, 0, 1]])
    assert analysis.cubatic_order(vertices / np.sqrt(1 + golden**2))[0] == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize(("seed", "n"), [(12, 60), (93, 8), (117, 8), (233, 3)])        # the last three have lower maxima as well
def test_no_frame_has_more_cubatic_order(seed, n):
    """Against a search: the best of many frames at random, then scipy's simplex."""
    axes = random_axes(np.random.default_rng(seed), n)
    order, directions = analysis.cubatic_order(axes)

    def of(frame):
        return (np.mean(np.sum((axes @ frame.T)**4, axis=1)) - 0.6) / 0.4

    assert of(directions) == pytest.approx(order, abs=1e-12)
    np.testing.assert_allclose(directions @ directions.T, np.eye(3), atol=1e-13)
    frames = Rotation.random(2000, random_state=1).as_matrix()
    best = sorted(frames, key=of)[-5:]
    searched = [-minimize(lambda turn, start=start: -of(start @ Rotation.from_rotvec(turn).as_matrix()), np.zeros(3), method="Nelder-Mead",
                          options={"xatol": 1e-7, "fatol": 1e-12}).fun for start in best]
    assert order == pytest.approx(max(searched), abs=1e-9)


def test_biaxial_and_cubatic_along_a_trajectory(tmp_path):
    q = np.stack([random_quaternions(np.random.default_rng(1), 9), np.tile([1.0, 0, 0, 0], (9, 1))])
    path = write_run(tmp_path / "run.h5md", np.random.default_rng(0).random((9, 3)), q, (3, 2, 1), np.eye(3) * 9, [0, 1])
    atoms = mda.Universe(path).atoms
    biaxial, cubatic = analysis.BiaxialOrder(atoms).run().results, analysis.CubaticOrder(atoms, all_axes=True).run().results
    assert (biaxial.uniaxial[1], biaxial.biaxial[1], cubatic.order[1]) == pytest.approx((1, 1, 1), abs=1e-12)
    assert biaxial.biaxial[0] == analysis.biaxial_order(q[0])[1]
    assert cubatic.order[0] == analysis.cubatic_order(analysis.three_axes(q[0]))[0] < 0.95
    assert biaxial.directors.shape == cubatic.directions.shape == (2, 3, 3)
