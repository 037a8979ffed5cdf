import MDAnalysis as mda
import numpy as np
import pytest
from runs import random_quaternions, write_run
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
