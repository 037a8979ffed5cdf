"""Two numbers side by side: each lane has the bits that a number alone would have, compiled and in plain Python."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccd.compiling import kernel
from ccd.first_contact import bend_until, grown, support_course
from ccd.free_top import fastest_turning, is_short, jolts, top_from, top_of, turn_shortly, turn_top
from ccd.lanes import abreast, absolute, first, first_of, greater, least, lesser, most, second, second_of, sqrt, total, two, where_less
from ccd.rotation import axes_of_any, cos_and_sinc, turn
from ccd.turning_plane import facing

NUMBERS = st.floats(-1e3, 1e3).filter(lambda x: abs(x) > 1e-9)


@kernel
def reckoned(x, y, z):
    """Every operation; of numbers and of lanes."""
    x += y
    u = (x - 2.0 * y) * z / (1 + y * y) - 3 / z
    u *= -x
    u -= 1.5
    u /= 2
    v = where_less(u, z, sqrt(absolute(u)), 7.0)
    return u, v, greater(u, v), lesser(u, 0.25), where_less(0.0, x, 1.0, y)


@kernel
def reckoned_side_by_side(a, b):
    u = reckoned(two(a[0], b[0]), two(a[1], b[1]), two(a[2], b[2]))
    return ((first(u[0]), first(u[1]), first(u[2]), first(u[3]), first(u[4])),
            (second(u[0]), second(u[1]), second(u[2]), second(u[3]), second(u[4])), total(u[0]), most(u[1]), least(u[1]))


@settings(derandomize=True, max_examples=200, deadline=None)
@given(st.tuples(NUMBERS, NUMBERS, NUMBERS), st.tuples(NUMBERS, NUMBERS, NUMBERS))
def test_every_operation_gives_the_bits_of_a_number_alone(a, b):
    one, other = reckoned(*a), reckoned(*b)
    found = reckoned_side_by_side(a, b)
    assert found == (one, other, one[0] + other[0], max(one[1], other[1]), min(one[1], other[1]))


@kernel
def roots(x, y, z):
    u = (x - 2.0 * y) * z / (1 + y * y) - 3 / z
    return u, where_less(-u, z, sqrt(absolute(u)), 7.0)


@settings(derandomize=True, max_examples=50, deadline=None)
@given(st.tuples(NUMBERS, NUMBERS, NUMBERS), st.tuples(NUMBERS, NUMBERS, NUMBERS))
def test_plain_python_gives_the_same_bits(a, b):
    x, y, z = (two(*pair) for pair in zip(a, b))
    u = (x - 2.0 * y) * z / (1 + y * y) - 3 / z
    v = where_less(-u, z, sqrt(absolute(u)), 7.0)
    one, other = roots(*a), roots(*b)
    assert (first(u), first(v), second(u), second(v)) == (*one, *other)
    assert (most(v), least(v), most(2.0)) == (max(one[1], other[1]), min(one[1], other[1]), 2.0)
    assert repr(two(1.0, -2.5)) == "two(1.0, -2.5)"


def test_a_comparison_with_no_number_fails():
    assert where_less(math.nan, 1.0, 2.0, 3.0) == where_less(1.0, math.nan, 2.0, 3.0) == 3.0
    for none, one in (((math.nan, 1.0, 1.0), (2.0, 1.0, 1.0)), ((1.0, 1.0, math.nan), (2.0, 1.0, 1.0))):
        for pair, lane in (((none, one), 0), ((one, none), 1)):
            found = reckoned_side_by_side(*pair)
            assert found[lane][1] == 7.0
            assert found[1 - lane] == reckoned(*one)


@kernel
def cos_and_sinc_side_by_side(a, b):
    c, s = cos_and_sinc(two(a, b))
    return (first(c), first(s)), (second(c), second(s))


@pytest.mark.parametrize("a", [0.0, 1e-9, 0.2, 0.25, 0.3, 40.0])
@pytest.mark.parametrize("b", [0.0, 0.24999, 0.25001, 1e4])
def test_an_angle_takes_its_own_way_whatever_its_neighbour(a, b):
    """By the series up to a half-angle of 0.5, by the library beyond."""
    assert cos_and_sinc_side_by_side(a, b) == (cos_and_sinc(a), cos_and_sinc(b))


def bodies(seed, moments):
    """Two of them: semi-axis vectors, orientation, momentum, inverse moments; a direction, and a short time."""
    rng = np.random.default_rng(seed)

    def body():
        q = rng.normal(size=4)
        axes = axes_of_any(tuple(q))
        sizes = np.exp(rng.uniform(-1, 1, 3))
        vectors = tuple(tuple(float(size * x) for x in axis) for size, axis in zip(sizes, axes))
        return vectors, tuple((q / np.linalg.norm(q)).tolist()), tuple(rng.normal(size=3).tolist()), moments(rng)

    n = rng.normal(size=3)
    return body(), body(), tuple((n / np.linalg.norm(n)).tolist()), rng.uniform(0.001, 0.05)


MOMENTS = {"three": lambda rng: tuple(rng.uniform(0.7, 1.0, 3).tolist()), "equal": lambda rng: (0.8, 0.8, 0.8),
           "two equal": lambda rng: (1.0, 0.6, 0.6)}


@kernel
def seen(vectors, spin, n):
    """What the bounds take of a body, from two rooms."""
    course = support_course(vectors, (spin, n, 0.7, 3.0, 0.1, 2.0), n)
    h, c, _, drift, over = facing(vectors, (1.25, spin, 0.125), n)
    height, rate, bend = grown((course[0], course[1], bend_until(course, 0.5)), 1.25, 0.125, 0.5)
    return (h, over, height), c, drift, (rate, bend, course[3])


@kernel
def seen_side_by_side(a, b, spin_a, spin_b, n):
    x = seen((abreast(a[0], b[0]), abreast(a[1], b[1]), abreast(a[2], b[2])), abreast(spin_a, spin_b), n)
    return ((first_of(x[0]), first_of(x[1]), first_of(x[2]), first_of(x[3])),
            (second_of(x[0]), second_of(x[1]), second_of(x[2]), second_of(x[3])))


@pytest.mark.parametrize("seed", range(30))
def test_two_bodies_are_seen_as_each_alone(seed):
    a, b, n, _ = bodies(seed, MOMENTS["three"])
    assert seen_side_by_side(a[0], b[0], a[2], b[2], n) == (seen(a[0], a[2], n), seen(b[0], b[2], n))


@kernel
def topped(q, momentum, moments, time):
    """What is known of a free top, and where it has turned."""
    top = top_of(q, momentum, moments)
    speed, change = fastest_turning(top, moments)
    third, fourth = jolts(speed, change, 0.3, 2.0)
    again = top_from(top.length, top.x, top.spin, top.swerve, top.square, moments)
    p = turn_shortly(again, q, moments, 0.5 * time)
    steady = turn(q, momentum, time)
    return (speed, change, third), (fourth, top.length, top.swerve), (p[0], p[1], p[2]), (p[3], steady[0], steady[1])


@kernel
def topped_side_by_side(a, b, time):
    q = abreast(a[0][:3], b[0][:3]) + (two(a[0][3], b[0][3]),)
    x = topped(q, abreast(a[1], b[1]), abreast(a[2], b[2]), two(time, 2 * time))
    return ((first_of(x[0]), first_of(x[1]), first_of(x[2]), first_of(x[3])),
            (second_of(x[0]), second_of(x[1]), second_of(x[2]), second_of(x[3])))


@kernel
def turned_alone(q, momentum, moments, time):
    top = top_of(q, momentum, moments)
    return is_short(top, 0.5 * time), turn_top(top, q, momentum, moments, time)


@pytest.mark.parametrize("moments", MOMENTS)
@pytest.mark.parametrize("seed", range(10))
def test_two_tops_turn_as_each_alone(seed, moments):
    a, b, _, time = bodies(seed, MOMENTS[moments])
    one, other = topped(*a[1:], time), topped(*b[1:], 2 * time)
    assert topped_side_by_side(a[1:], b[1:], time) == (one, other)
    short, q = turned_alone(*a[1:], time)
    assert short
    assert (*one[2], one[3][0]) == q
