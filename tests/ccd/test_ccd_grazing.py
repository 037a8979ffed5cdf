"""Tangential contacts, slight overlaps and slight separations, contacts at the ends of the span: built so that the answer is known exactly.

Bodies of one shape and parallel axes, s and S times as large, touch where their centres are s + S of those shapes apart, whatever map
carries both. So a path of the centre in the frame of a common motion tells all times.
"""

from functools import reduce

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyadd, polymul

import ccd
from ccd import AffineMotion, Ellipsoid, RationalMotion, Rest, State, Status

SEPARATE, OVERLAPPING, TOUCHING, UNRESOLVED = State.SEPARATE, State.OVERLAPPING, State.TOUCHING, State.UNRESOLVED
SHAPE, SMALL, LARGE = np.array([1.0, 0.5, 2.0]), 0.75, 1.25              # at contact |r / SHAPE| is 2
DEPTHS = [1e-3, 1e-5, 1e-7, 1e-9]


def stack(rows):
    size = max(len(row) for row in rows)
    return np.array([np.pad(row, (0, size - len(row))) for row in rows])


def plain(path):
    """A sits at the origin, B moves."""
    return Ellipsoid(SMALL * SHAPE), Rest(), Ellipsoid(LARGE * SHAPE), RationalMotion([[1], [0], [0], [0]], path)


def turned(path):
    """Both turn by one rational rotation of degree 2, which carries the path too."""
    e = np.array([[1.0, 0.25], [0.5, -1.0], [0.0, 0.75], [-0.5, 0.5]])
    w, x, y, z = e

    def square(*terms):
        return reduce(polyadd, [factor * polymul(p, q) for factor, p, q in terms])
    u = [[square((1, w, w), (1, x, x), (-1, y, y), (-1, z, z)), square((2, x, y), (-2, w, z)), square((2, x, z), (2, w, y))],
         [square((2, x, y), (2, w, z)), square((1, w, w), (-1, x, x), (1, y, y), (-1, z, z)), square((2, y, z), (-2, w, x))],
         [square((2, x, z), (-2, w, y)), square((2, y, z), (2, w, x)), square((1, w, w), (-1, x, x), (-1, y, y), (1, z, z))]]
    carried = stack([reduce(polyadd, [polymul(u[i][j], path[j]) for j in range(3)]) for i in range(3)])
    return (Ellipsoid(SMALL * SHAPE), RationalMotion(e, np.zeros((3, 1))), Ellipsoid(LARGE * SHAPE),
            RationalMotion(e, carried, square((1, w, w), (1, x, x), (1, y, y), (1, z, z))))


def sheared(path):
    """Both are carried by one affine motion of degree 1."""
    linear = np.array([[[1.0, 0.5], [0.25, 0], [0, 0.5]], [[0, 0], [1.5, -0.5], [0.25, 0.25]], [[0.5, 0], [0, 0.25], [1.0, 0.25]]])
    carried = stack([reduce(polyadd, [polymul(linear[i, j], path[j]) for j in range(3)]) for i in range(3)])
    return (Ellipsoid(SMALL * SHAPE), AffineMotion(linear, np.zeros((3, 1))), Ellipsoid(LARGE * SHAPE), AffineMotion(linear, carried))


CARRIED = pytest.mark.parametrize("carried", [plain, turned, sheared])


def past(depth, middle=0.375, speed=8.0):
    """Straight past A, at the nearest a part `depth` nearer than touching."""
    return np.array([[-speed * middle, speed], [0, 0], [0, 0]]) * SHAPE[:, None] + np.array([[0, 0], [2 - 2 * depth, 0], [0, 0]]) * SHAPE[1]


def bounce(height, middle=0.625, bend=8.0):
    """Away from A and back: at `middle` a part `height` further than touching, overlapping before and after; down and up for bend < 0."""
    return np.array([[2 + 2 * height - bend * middle**2, 2 * bend * middle, -bend], [0, 0, 0], [0, 0, 0]]) * SHAPE[:, None]


def only(found):
    return [interval.state for interval in found]


@CARRIED
@pytest.mark.parametrize("depth", DEPTHS)
def test_a_grazing_overlap_is_found(carried, depth):
    found = ccd.contact_intervals(*carried(past(depth)))
    half = np.sqrt(4 - (2 - 2 * depth) ** 2) / 8
    assert only(found) == [SEPARATE, OVERLAPPING, SEPARATE]
    error = 1e-9 if depth > 1e-8 else 1e-7
    assert found[1].start == pytest.approx(0.375 - half, abs=error)
    assert found[1].end == pytest.approx(0.375 + half, abs=error)


@CARRIED
@pytest.mark.parametrize("depth", DEPTHS)
def test_a_near_miss_is_no_contact(carried, depth):
    assert only(ccd.contact_intervals(*carried(past(-depth)))) == [SEPARATE]


@CARRIED
@pytest.mark.parametrize("height", DEPTHS)
def test_a_tiny_loop_of_separation_is_found(carried, height):
    found = ccd.contact_intervals(*carried(bounce(height)))
    half = np.sqrt(2 * height / 8)
    assert only(found) == [OVERLAPPING, SEPARATE, OVERLAPPING]
    error = 1e-9 if height > 1e-8 else 1e-7
    assert found[1].start == pytest.approx(0.625 - half, abs=error)
    assert found[1].end == pytest.approx(0.625 + half, abs=error)


@CARRIED
@pytest.mark.parametrize("height", DEPTHS)
def test_bodies_that_nearly_come_apart_overlap(carried, height):
    assert only(ccd.contact_intervals(*carried(bounce(-height)))) == [OVERLAPPING]


@CARRIED
@pytest.mark.parametrize("depth", DEPTHS)
def test_a_dip_as_deep_as_asked_overlaps_that_long(carried, depth):
    found = ccd.contact_intervals(*carried(bounce(-depth, bend=-8.0)))
    half = np.sqrt(2 * depth / 8)
    assert only(found) == [SEPARATE, OVERLAPPING, SEPARATE]
    error = 1e-9 if depth > 1e-8 else 1e-7
    assert found[1].start == pytest.approx(0.625 - half, abs=error)
    assert found[1].end == pytest.approx(0.625 + half, abs=error)


def _tangential(found, around, time):
    """An instant between two intervals of one state; where rounding decides a UNRESOLVED one, or a sliver of the other, as narrow."""
    assert found[0].state == found[-1].state == around
    assert len(found) == 3
    middle = found[1]
    assert middle.state in (TOUCHING, UNRESOLVED, State(-around))
    assert middle.start == pytest.approx(time, abs=2e-6)
    assert middle.end == pytest.approx(time, abs=2e-6)
    return middle


@CARRIED
@pytest.mark.parametrize(("path", "time"), [(past(0.0), 0.375), (bounce(0.0, bend=-8.0), 0.625)])
def test_a_tangential_contact_from_outside(carried, path, time):
    _tangential(ccd.contact_intervals(*carried(path)), SEPARATE, time)


@CARRIED
def test_a_tangential_contact_from_inside(carried):
    _tangential(ccd.contact_intervals(*carried(bounce(0.0))), OVERLAPPING, 0.625)


@pytest.mark.parametrize(("path", "time", "around"), [(past(0.0), 0.375, SEPARATE), (bounce(0.0, bend=-8.0), 0.625, SEPARATE),
                                                      (bounce(0.0), 0.625, OVERLAPPING)])
def test_an_exactly_tangential_contact_is_one_instant_with_its_point(path, time, around):
    found = ccd.contact_intervals(*plain(path))
    touch = _tangential(found, around, time)
    assert touch.state == TOUCHING
    assert touch.start == touch.end == pytest.approx(time, abs=1e-8)
    center = np.array([sum(c * time**k for k, c in enumerate(row)) for row in path])
    np.testing.assert_allclose(touch.start_point, center * SMALL / 2, rtol=0, atol=1e-7)


@pytest.mark.parametrize("path", [[[2.0], [0], [0]], [[0.0], [1.0], [0.0]], [[0.0], [0.0], [-4.0]]])
def test_contact_that_lasts_is_touching(path):
    found = ccd.contact_intervals(*plain(path))
    assert only(found) == [TOUCHING]
    np.testing.assert_allclose(found[0].start_point, np.ravel(path) * SMALL / 2, rtol=0, atol=1e-9)


def test_spheres_that_roll_on_each_other_touch_all_the_time():
    circle = np.array([[2.0, 0, -2.0], [0, 4.0, 0], [0, 0, 0]])            # of radius 2, over 1 + t^2
    rolling = RationalMotion([[1, 0], [0, 0], [0, 0], [0, 1.0]], circle, [1.0, 0, 1.0])
    assert only(ccd.contact_intervals(Ellipsoid((1, 1, 1)), Rest(), Ellipsoid((1, 1, 1)), rolling)) == [TOUCHING]


@CARRIED
@pytest.mark.parametrize(("speed", "state"), [(1.0, SEPARATE), (-1.0, OVERLAPPING)])
def test_contact_at_the_start_and_at_the_end_of_the_span(carried, speed, state):
    """Touching at t = 0 and then apart or overlapping, and the same backwards."""
    forward, backward = np.zeros((3, 2)), np.zeros((3, 2))
    forward[0], backward[0] = (2, speed), (2 + speed, -speed)
    found = ccd.contact_intervals(*carried(forward))
    assert only(found) == [state]
    assert np.isfinite(found[0].start_point).all()
    found = ccd.contact_intervals(*carried(backward))
    assert only(found) == [state]
    assert np.isfinite(found[0].end_point).all()


@CARRIED
def test_a_tangential_contact_at_the_end_of_the_span(carried):
    for middle in (0.0, 1.0):
        found = ccd.contact_intervals(*carried(bounce(0.0, middle=middle, bend=-8.0)))
        wide = [interval.state for interval in found if interval.end - interval.start > 1e-5]
        assert wide == [SEPARATE]
        assert OVERLAPPING not in only(found)


def test_the_first_contact_of_bodies_that_touch_at_the_start():
    apart, into = np.zeros((3, 2)), np.zeros((3, 2))
    apart[0], into[0] = (2, 1.0), (2, -1.0)
    assert ccd.first_contact(*plain(apart)).status == Status.NO_CONTACT
    touching = ccd.first_contact(*plain(into))
    assert (touching.status, touching.time) == (Status.CONTACT, 0.0)
    np.testing.assert_allclose(touching.normal, [1, 0, 0], rtol=0, atol=1e-12)


@CARRIED
@pytest.mark.parametrize("depth", [0.0, *DEPTHS])
def test_the_first_contact_of_a_graze_is_not_missed(carried, depth):
    found = ccd.first_contact(*carried(past(depth)))
    if depth > 0:
        assert found.status == Status.CONTACT
    assert found.status in (Status.CONTACT, Status.UNRESOLVED, Status.NO_CONTACT)
    if found.status == Status.CONTACT:
        assert found.time == pytest.approx(0.375 - np.sqrt(4 - (2 - 2 * depth) ** 2) / 8, abs=1e-6 if depth < 1e-8 else 1e-9)
    assert ccd.first_contact(*carried(past(-max(depth, 1e-9)))).status == Status.NO_CONTACT


@CARRIED
@pytest.mark.parametrize("depth", [1e-10, 1e-11, 1e-12, 1e-13, 1e-15])
def test_depths_at_the_end_of_double_precision_are_never_told_wrong(carried, depth):
    """Below 1e-12 of f touching and overlapping are one; what is told must not contradict what is away from there."""
    for path, around, time in ((past(depth), SEPARATE, 0.375), (past(-depth), SEPARATE, 0.375), (bounce(depth), OVERLAPPING, 0.625),
                               (bounce(-depth), OVERLAPPING, 0.625)):
        found = ccd.contact_intervals(*carried(path))
        assert found[0].state == found[-1].state == around
        for interval in found[1:-1]:
            assert abs(interval.start - time) < 1e-4
            assert abs(interval.end - time) < 1e-4
