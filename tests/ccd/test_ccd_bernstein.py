"""Polynomials in Bernstein form: held against numpy's polynomials and mpmath's roots."""

from math import inf

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from ccd import bernstein as bz

modest = settings(derandomize=True, deadline=None, max_examples=150)
T = np.linspace(0, 1, 41)


def weighted(powers, start=0.0, width=1.0):
    out = np.empty(len(powers))
    bz.from_powers(out, np.asarray(powers, dtype=float), start, width)
    return out


def points(powers):
    p = weighted(powers)
    c = np.empty_like(p)
    bz.control_points(p, c)
    return c


def exact_value(c, t):
    """Control points at t in 40 digits."""
    n = len(c) - 1
    with mpmath.workdps(40):
        t = mpmath.mpf(float(t))
        return sum(mpmath.binomial(n, i) * mpmath.mpf(float(x)) * t**i * (1 - t) ** (n - i) for i, x in enumerate(c))


def first_root(c):
    return bz.first_root(np.asarray(c, dtype=float), np.empty(len(c)))


def from_roots(roots, degree=None):
    """Control points of a polynomial that is positive at 0, multiplied out in 60 digits."""
    with mpmath.workdps(60):
        c = [mpmath.mpf(1)]                                     # of the product of (r - s) = r (1 - s) + (r - 1) s, weighted
        for r in roots:
            r = mpmath.mpf(r)
            c = [(c[i] * r if i < len(c) else 0) + (c[i - 1] * (r - 1) if i else 0) for i in range(len(c) + 1)]
        for _ in range(len(c) - 1, degree or 0):
            c = [(c[i] if i < len(c) else 0) + (c[i - 1] if i else 0) for i in range(len(c) + 1)]
        n = len(c) - 1
        sign = 1 if c[0] >= 0 else -1
        return np.array([float(sign * x / mpmath.binomial(n, i)) for i, x in enumerate(c)])


def test_binomials():
    assert bz.binomials(5).tolist() == [1, 5, 10, 10, 5, 1]
    assert bz.binomials(60)[30] == pytest.approx(118264581564861424, rel=1e-15)


@pytest.mark.parametrize(("n", "m"), [(0, 0), (0, 4), (3, 0), (2, 5), (10, 30)])
def test_products_and_elevation(n, m):
    rng = np.random.default_rng(n + m)
    p, q = rng.normal(size=n + 1), rng.normal(size=m + 1)
    out = np.full(n + m + 1, 7.0)
    bz.set_product(out, -2.0, weighted(p), weighted(q))
    np.testing.assert_allclose(out, weighted((-2 * Polynomial(p) * Polynomial(q)).coef), rtol=1e-10, atol=1e-9 * abs(out).max())
    again = out.copy()
    bz.add_product(again, 2.0, weighted(p), weighted(q))
    np.testing.assert_allclose(again, 0, atol=1e-12 * abs(out).max())
    raised = np.empty(n + 8)
    raised[:n + 1] = weighted(p)
    bz.elevate(raised, n, n + 7)
    for t in T:
        assert bz.value(raised, t) == pytest.approx(Polynomial(p)(t), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("degree", [0, 1, 2, 7, 20])
def test_conversion_from_powers_on_any_span(degree):
    rng = np.random.default_rng(degree)
    powers = rng.normal(size=degree + 1)
    for start, width in ((0, 1), (-0.5, 1.25), (0.3, 1e-3)):
        p = weighted(powers, start, width)
        for t in T:
            assert bz.value(p, t) == pytest.approx(Polynomial(powers)(start + width * t), rel=1e-10, abs=1e-11)


@pytest.mark.parametrize("degree", [0, 1, 3, 10, 34])
def test_restriction_is_the_polynomial_on_the_part(degree):
    rng = np.random.default_rng(degree)
    c = rng.normal(size=degree + 1)
    for low, high in ((0, 1), (0, 0.25), (0.5, 1), (0.3, 0.3001), (0.999, 1)):
        part = c.copy()
        bz.restrict(part, low, high)
        for t in (0, 0.2, 0.7, 1):
            assert float(exact_value(part, t)) == pytest.approx(float(exact_value(c, low + t * (high - low))), abs=1e-13)


def test_the_last_instant_is_a_part_too():
    c = np.array([1.0, 2.0, 5.0])
    bz.restrict(c, 1.0, 1.0)
    assert c.tolist() == [5, 5, 5]


def test_a_root_at_the_start_divides_out():
    p = points([0.0, 3.0, -1.0, 2.0])
    bz.without_root_at_start(p)
    np.testing.assert_allclose(p[:3], points([3.0, -1.0, 2.0]), rtol=1e-14)


@pytest.mark.parametrize("seed", range(60))
def test_the_first_root_of_random_polynomials(seed):
    """Against numpy's eigenvalues; from below."""
    rng = np.random.default_rng(seed)
    degree = int(rng.integers(1, 13))
    roots = np.sort(rng.uniform(-1, 2, degree))
    c = from_roots(roots.tolist())
    inside = roots[(roots >= 0) & (roots <= 1)]
    found = first_root(c)
    if len(inside) == 0:
        assert found == inf
    else:
        gaps = np.diff(np.append(roots, np.inf)).min()
        assert found == pytest.approx(inside[0], abs=1e-13 + 1e-13 / max(gaps, 1e-9) ** 2)
        assert found <= inside[0] + 1e-9


@pytest.mark.parametrize("root", [0.1, 0.5, 0.7, 0.999])
@pytest.mark.parametrize("times", [2, 4])
def test_a_multiple_root_is_approached_from_below_to_what_rounding_allows(root, times):
    found = first_root(from_roots([root] * times + [1.5]))
    if found < inf:
        assert root - 1e-13 ** (1 / times) * 3 <= found <= root + 1e-13 ** (1 / times) * 3


@pytest.mark.parametrize("apart", [1e-2, 1e-4, 1e-6])
def test_the_first_of_a_cluster(apart):
    found = first_root(from_roots([0.4, 0.4 + apart, 0.4 + 2 * apart]))
    assert found == pytest.approx(0.4, abs=1e-13 / apart**2 if apart > 1e-5 else 1e-4)


@pytest.mark.parametrize("above", [1e-2, 1e-6, 1e-10, 1e-13])
def test_no_root_where_the_polynomial_stays_above_zero(above):
    """(s - 0.4)^2 + above."""
    assert first_root(np.array([0.16 + above, -0.24 + above, 0.36 + above])) == inf
    below = first_root(np.array([0.16 - above, -0.24 - above, 0.36 - above]))
    assert below == pytest.approx(0.4 - np.sqrt(above), abs=1e-16 / np.sqrt(above) * 10 + 1e-15)


@pytest.mark.parametrize(("c", "expected"), [([0.0, 1.0], 0.0), ([1.0, 0.0], 1.0), ([1.0, 1.0, 0.0], 1.0), ([-1.0, 2.0], 0.0), ([2.0], inf),
                                             ([0.0], 0.0), ([-1.0], 0.0), ([1.0, 3.0, 1.0], inf), ([1.0, -1.0], 0.5),
                                             ([0.15625, 0.0, 1.0, 0.0], 1.0)])
def test_roots_at_the_ends_and_constants(c, expected):
    found = first_root(c)
    assert found == pytest.approx(expected, abs=1e-15)
    assert 0 <= found <= 1 or found == inf


@modest
@given(st.lists(st.floats(-1, 1).map(lambda x: round(x, 6)), min_size=2, max_size=20))
def test_nothing_is_zero_before_the_first_root(c):
    """Whatever the polynomial: at 200 times before the bound it is not negative, and without a bound nowhere."""
    found = first_root(c)
    if c[0] <= 0:
        assert found == 0
        return
    end = 1.0 if found == inf else found
    assert 0 <= end <= 1
    largest = max(map(abs, c))
    for t in np.linspace(0, end, 60):
        assert exact_value(c, t) > -1e-14 * largest
    if found < inf:
        ahead = min(exact_value(c, min(found + step, 1.0)) for step in (0, 1e-15, 1e-12, 1e-9, 1e-7))
        assert ahead < 1e-11 * largest


@modest
@given(st.lists(st.floats(-1, 1).map(lambda x: round(x, 4)), min_size=1, max_size=12))
def test_a_sign_that_is_said_to_be_kept_is_kept(c):
    p = np.array(c) * bz.binomials(len(c) - 1)
    values = np.array([float(exact_value(c, t)) for t in np.linspace(0, 1, 40)])
    kept = bz.keeps_sign(p, np.empty((2, len(c))))
    if kept:
        assert (values > 0).all() or (values < 0).all()
    elif (values > 0).all() or (values < 0).all():
        assert abs(values).min() < 0.02 * max(map(abs, c))          # so near zero that 40 looks may miss a root


@pytest.mark.parametrize(("powers", "kept"), [([1.0], True), ([0.0], False), ([1.0, -1.0], False), ([1.0, -0.999], True),
                                              ([0.0, 1.0], False), ([0.25, -1.0, 1.0], False), ([0.2501, -1.0, 1.0], True),
                                              ([-3.0, 1.0], True), ([1e-300, 1e-300], True)])
def test_keeps_sign(powers, kept):
    assert bz.keeps_sign(weighted(powers), np.empty((2, len(powers)))) == kept
