"""F(u, t) of the CCD equation: its degrees, and its values against determinants in 50 digits."""

import numpy as np
import pytest
from determinants import affine as exact_affine
from determinants import determinant
from determinants import rigid as exact_rigid
from rational_pairs import EXAMPLE_1, affine, crossing, denominators, interpolated, pair, resting, rigid, single, turning

import ccd
from ccd import AffineMotion, CCDEquation, Ellipsoid, RationalMotion, Rest

A, B = Ellipsoid((1.0, 0.5, 2.0)), Ellipsoid((0.7, 1.1, 0.4))


def moving(rotation, translation, denominator=0, seed=0):
    rng = np.random.default_rng([rotation, translation, denominator, seed])
    return RationalMotion(turning(rng, 1, rotation)[0], crossing(rng, 1, translation)[0], denominators(rng, 1, denominator)[0])


def exact(motion):
    if isinstance(motion, AffineMotion):
        return exact_affine(motion.linear, motion.translation, motion.denominator)
    return exact_rigid(motion.rotation, motion.translation, motion.denominator)


@pytest.mark.parametrize(("motion_a", "motion_b", "paper", "minimal"), [
    (moving(2, 3), moving(2, 3, seed=1), 34, 14),
    (moving(2, 1), moving(2, 1, seed=1), 30, 10),
    (moving(2, 2, 2), Rest(), 32, 8),
    (moving(4, 4, 4), Rest(), 64, 16),
    (Rest(), moving(6, 6, 6), 96, 24),
    (Rest(), Rest(), 0, 0),
])
def test_degrees_are_those_of_the_errata(motion_a, motion_b, paper, minimal):
    equation = CCDEquation(A, motion_a, B, motion_b)
    assert (equation.degree_t, equation.minimal_degree_t) == (paper, minimal)
    assert equation.bernstein.shape == (5, paper + 1)
    assert equation.minimal.shape == (5, minimal + 1)


def test_degrees_of_example_1_of_bodies_at_rest_and_of_the_affine_interpolant():
    equation = CCDEquation(*EXAMPLE_1)
    assert (equation.degree_t, equation.minimal_degree_t) == (34, 14)
    assert CCDEquation(A, Rest(), B, moving(2, 1)).minimal_degree_t == 6
    _, _, corners = interpolated(np.random.default_rng(0), 1)
    a, _, b, _ = corners[0]
    equation = CCDEquation(Ellipsoid(a.semi_axes), Rest(), Ellipsoid(b.semi_axes), ccd.interpolate_affine(*corners[0]))
    assert (equation.degree_t, equation.minimal_degree_t) == (6, 5)


def test_the_sixth_power_vanishes_for_the_affine_interpolant():
    """Elevated to degree 6, differences of the sixth order of F's coefficients are 0; and F is the determinant."""
    rng = np.random.default_rng(1)
    a, b, corners = interpolated(rng, 10)
    for k in range(10):
        motion = ccd.interpolate_affine(*corners[k])
        first, second = Ellipsoid(a.semi_axes[k]), Ellipsoid(b.semi_axes[k])
        equation = CCDEquation(first, Rest(), second, motion)
        sixth = np.diff(equation.bernstein, n=6, axis=1)
        assert abs(sixth).max() < 1e-12 * 64 * abs(equation.bernstein).max()
        t, u = np.linspace(0, 1, 7), np.linspace(0.1, 0.9, 5)
        inverse = (1 - t)[:, None, None] * b.inverses[k, 0] + t[:, None, None] * b.inverses[k, 1]
        center = (1 - t)[:, None] * b.centers[k, 0] + t[:, None] * b.centers[k, 1]
        values = np.empty((5, 7))
        for j in range(7):
            quadric = np.block([[inverse[j], -(inverse[j] @ center[j])[:, None]],
                                [-(inverse[j] @ center[j])[None], center[j] @ inverse[j] @ center[j] - 1]])
            values[:, j] = [np.linalg.det((v - 1) * first.quadric - v * quadric) for v in u]
        ratio = equation(u[:, None], t[None]) / values
        assert (ratio > 0).all()
        np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-7)               # not even a factor of t


def pairs():
    rng = np.random.default_rng(2)
    for degree, translation, denominator in ((2, 1, 0), (2, 3, 2), (4, 2, 1), (6, 4, 3)):
        a, b = rigid(rng, 1, degree, translation, denominator), rigid(rng, 1, 2, 2, 1)
        yield pair(a, b, 0)
        yield (*single(resting(a.semi_axes), 0), *single(b, 0))
        yield (*single(affine(rng, 1, degree // 2, translation, denominator), 0), *single(b, 0))
        yield (*single(affine(rng, 1, 1, 1), 0), *single(affine(rng, 1, degree // 2, 1, 1), 0))
        yield (*single(b, 0), *single(affine(rng, 1, 1, translation, denominator), 0))


@pytest.mark.parametrize("bodies", list(pairs()))
def test_f_is_the_determinant_times_a_positive_factor_of_time(bodies):
    """The ratio is positive and the same for all u."""
    a, motion_a, b, motion_b = bodies
    span = (0.0625, 0.875)
    equation = CCDEquation(a, motion_a, b, motion_b, t_span=span)
    for t in (span[0], 0.125, 0.625, span[1]):
        u = np.array([0.0, 0.15, 0.4, 0.65, 1.0])
        values = [determinant(a.semi_axes, exact(motion_a), b.semi_axes, exact(motion_b), x, t) for x in u]
        ratio = np.array([float(f / v) for f, v in zip(equation(u, t), values)])
        assert (ratio > 0).all()
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-8)
        rows = equation.minimal
        n, s = rows.shape[1] - 1, (t - span[0]) / (span[1] - span[0])
        basis_t = np.array([np.prod([(n - k) / (k + 1) for k in range(i)]) * s**i * (1 - s) ** (n - i) for i in range(n + 1)])
        basis_u = np.array([[c * x**i * (1 - x) ** (4 - i) for i, c in enumerate((1, 4, 6, 4, 1))] for x in u])
        minimal = np.array([float(f / v) for f, v in zip(basis_u @ (rows @ basis_t), values)])
        assert (minimal > 0).all()
        np.testing.assert_allclose(minimal, minimal[0], rtol=1e-8)


@pytest.mark.parametrize("bodies", list(pairs())[::3])
def test_both_degrees_give_the_same_intervals(bodies):
    minimal = CCDEquation(*bodies).contact_intervals()
    paper = CCDEquation(*bodies, degree="paper").contact_intervals()
    assert [i.state for i in minimal] == [i.state for i in paper]
    np.testing.assert_allclose([i.end for i in minimal], [i.end for i in paper], rtol=0, atol=1e-6)


def test_d_and_n_have_positive_coefficients_in_u():
    rng = np.random.default_rng(3)
    for bodies in pairs():
        equation = CCDEquation(*bodies)
        for t in rng.uniform(0, 1, 10):
            d_0, d_3 = -equation(0.0, t), -equation(1.0, t)
            assert d_0 > 0
            assert d_3 > 0
        from ccd.grid import coefficients
        for part in equation._parts:
            for s in rng.uniform(0, 1, 10):
                assert all(x > 0 for row in coefficients(part.grid, s) for x in row)


@pytest.mark.parametrize(("rotation", "translation", "denominator", "minimal"), [(16, 3, 0, 38), (20, 10, 0, 60), (12, 12, 12, 48)])
def test_any_degree(rotation, translation, denominator, minimal):
    motion = moving(rotation, translation, denominator)
    equation = CCDEquation(A, Rest(), B, motion)
    assert equation.minimal_degree_t == minimal
    for t in (0.0, 0.375, 1.0):
        u = np.array([0.1, 0.5, 0.8])
        values = [determinant(A.semi_axes, exact(RationalMotion([[1], [0], [0], [0]], [[0], [0], [0]])), B.semi_axes, exact(motion), x, t)
                  for x in u]
        ratio = np.array([float(f / v) for f, v in zip(equation(u, t), values)])
        assert (ratio > 0).all()
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-6)


def test_f_takes_arrays_that_broadcast():
    equation = CCDEquation(*EXAMPLE_1)
    u, t = np.linspace(0, 1, 4)[:, None], np.linspace(0, 1, 6)
    table = equation(u, t)
    assert table.shape == (4, 6)
    assert table[2, 3] == pytest.approx(float(equation(u[2, 0], t[3])), rel=1e-13)
    assert abs(equation(2 / 3, 0.5)) < 1e-14 * abs(equation.bernstein).max()              # Example 1: u = 2/3 at the contact
