"""Bad rational motions are refused in words, and extreme ones neither crash, hang nor give nan."""

import numpy as np
import pytest
from rational_pairs import rigid, single

import ccd
from ccd import AffineMotion, CCDEquation, Ellipsoid, FreeFlight, RationalMotion, Rest, State, Status

NAN, INF = float("nan"), float("inf")
A, B = Ellipsoid((1, 1, 1)), Ellipsoid((1, 2, 3))
TURN, PATH, LINEAR = [[1, 0], [0, 1], [0, 0], [0, 0]], [[9, -9], [0, 0], [0, 0]], np.eye(3)[:, :, None]
GOOD = RationalMotion(TURN, PATH)
ASK = pytest.mark.parametrize("ask", [ccd.contact_intervals, ccd.first_contact, CCDEquation])


@pytest.mark.parametrize(("name", "wrong"), [
    *[("rotation", wrong) for wrong in ([1, 0, 0, 0], np.zeros((4, 2)), np.ones((3, 2)), np.full((4, 1), NAN), [[INF], [0], [0], [0]],
                                        np.ones((4, 0)), "turn", None, np.ones((4, 2, 1)))],
    *[("translation", wrong) for wrong in ([0, 0, 0], np.ones((4, 2)), np.full((3, 1), INF), np.ones((3, 0)), "far", None)],
    *[("denominator", wrong) for wrong in (1.0, [], [0.0], [0, 0, 0], [1, NAN], "one", None, [[1.0]])],
])
def test_rational_motions_are_finite_polynomials(name, wrong):
    with pytest.raises(ValueError, match=name):
        RationalMotion(**({"rotation": TURN, "translation": PATH, "denominator": (1.0,)} | {name: wrong}))


@pytest.mark.parametrize(("name", "wrong"), [
    *[("linear", wrong) for wrong in (np.eye(3), np.zeros((3, 3, 2)), np.full((3, 3, 1), NAN), np.ones((3, 3, 0)), "map", None)],
    *[("translation", wrong) for wrong in ([0, 0, 0], np.full((3, 1), INF), None)],
    *[("denominator", wrong) for wrong in (1.0, [], [0], [INF])],
])
def test_affine_motions_are_finite_polynomials(name, wrong):
    with pytest.raises(ValueError, match=name):
        AffineMotion(**({"linear": LINEAR, "translation": PATH, "denominator": (1.0,)} | {name: wrong}))


def flattening(root):
    """A linear map that is singular at one time."""
    return np.multiply.outer(np.diag([1, 0, 0]), [-root, 1]) + np.multiply.outer(np.diag([0, 1, 1]), [1, 0])


def refused(ask, motion, match, span=(0.0, 1.0)):
    with pytest.raises(ValueError, match=rf"^motion_a\.{match}"):
        ask(A, motion, B, Rest(), span)
    with pytest.raises(ValueError, match=rf"^motion_b\.{match}"):
        ask(A, GOOD, B, motion, span)


@ASK
@pytest.mark.parametrize("root", [0.0, 0.25, 0.5, 1.0])
def test_what_vanishes_inside_the_span_is_refused(ask, root):
    refused(ask, RationalMotion(np.outer([1, 2, 0, -1], [-root, 1]), PATH), "rotation")
    refused(ask, RationalMotion(TURN, PATH, [-root, 1]), "denominator")
    refused(ask, RationalMotion(TURN, PATH, [root**2, -2 * root, 1]), "denominator")
    refused(ask, AffineMotion(flattening(root), PATH), "linear")
    refused(ask, AffineMotion(LINEAR, PATH, [-root, 1]), "denominator")


@pytest.mark.parametrize("root", [-0.5, -1e-3, 1.001, 2.0])
def test_what_vanishes_outside_the_span_only_is_fine(root):
    turn = np.outer([1, 2, 0, -1], [-root, 1])
    stay = np.zeros((3, 1))
    for motion in (RationalMotion(turn, stay), RationalMotion(TURN, stay, [-root, 1]), AffineMotion(flattening(root), stay),
                   AffineMotion(LINEAR, stay, [-root, 1])):
        assert [i.state for i in ccd.contact_intervals(A, motion, B, Rest())] == [State.OVERLAPPING]
        with pytest.raises(ValueError, match=r"^motion_a\."):
            ccd.contact_intervals(A, motion, B, Rest(), (-3, 3))


@pytest.mark.parametrize("near", [1e-8, 1e-10, 1e-12])
def test_a_quaternion_that_nearly_vanishes_is_refused(near):
    """|q|^2 of 1e-13 of its largest and less is nothing."""
    with pytest.raises(ValueError, match="rotation"):
        ccd.contact_intervals(A, RationalMotion([[-0.5, 1], [near, 0], [0, 0], [0, 0]], PATH), B, Rest())


@pytest.mark.parametrize("near", [1e-2, 1e-4])
def test_a_fast_half_turn_is_not_refused(near):
    """A needle turns about x once, nearly all of it within a few `near`, and hits what lies there with both its ends."""
    motion = RationalMotion([[-0.5, 1], [near, 0], [0, 0], [0, 0]], np.zeros((3, 1)))
    needle, ball = Ellipsoid((0.1, 2.0, 0.1)), Ellipsoid((0.3, 0.3, 0.3), (0, 0, 1.5))
    found = ccd.contact_intervals(needle, motion, ball, Rest())
    assert [i.state for i in found] == [State.SEPARATE, State.OVERLAPPING] * 2 + [State.SEPARATE]
    assert found[1].start + found[3].end == pytest.approx(1, abs=1e-9)
    assert found[3].end - found[1].start < 6 * near


@ASK
@pytest.mark.parametrize("wrong", [(1, 0), (1, 1), (0, NAN), (0, INF), (0, 1, 2), (0,), 1.0, None, "ab"])
def test_spans_are_two_times_in_order(ask, wrong):
    with pytest.raises(ValueError, match="t_span"):
        ask(A, GOOD, B, Rest(), wrong)


@ASK
def test_bodies_and_motions_of_the_wrong_kind(ask):
    spinning = FreeFlight((0, 0, 0), (0, 0, 1))
    for wrong in (None, (1, 1, 1), GOOD):
        with pytest.raises(ValueError, match=r"^a = "):
            ask(wrong, GOOD, B, Rest())
        with pytest.raises(ValueError, match=r"^b = "):
            ask(A, GOOD, wrong, Rest())
    for wrong in (None, A, 3):
        with pytest.raises(ValueError, match="motion_a"):
            ask(A, wrong, B, GOOD)
        with pytest.raises(ValueError, match="motion_b"):
            ask(A, GOOD, B, wrong)
    with pytest.raises(ValueError, match=r"motion_a: .*approximate_flight"):
        ask(A, spinning, B, GOOD)
    with pytest.raises(ValueError, match=r"motion_b: .*approximate_flight"):
        ask(A, GOOD, B, spinning)


@pytest.mark.parametrize("wrong", ["Paper", 34, None])
def test_the_degree_is_minimal_or_the_paper_s(wrong):
    with pytest.raises(ValueError, match="degree"):
        CCDEquation(A, GOOD, B, Rest(), degree=wrong)


def test_interpolants_are_of_one_body_and_from_0_to_1():
    with pytest.raises(ValueError, match=r"end\.semi_axes"):
        ccd.interpolate_rigid(A, B)
    with pytest.raises(ValueError, match="start"):
        ccd.interpolate_rigid(None, B)
    with pytest.raises(ValueError, match=r"a_end\.semi_axes"):
        ccd.interpolate_affine(A, B, B, B)
    with pytest.raises(ValueError, match=r"b_end\.semi_axes"):
        ccd.interpolate_affine(A, A, B, A)
    with pytest.raises(ValueError, match="b_start"):
        ccd.interpolate_affine(A, A, 1, B)
    motion = ccd.interpolate_affine(A, A, B, Ellipsoid((1, 2, 3), (9, 0, 0)))
    with pytest.raises(ValueError, match=r"^motion_b\.semi_axes"):
        ccd.contact_intervals(A, Rest(), A, motion)
    for span in ((-0.1, 1), (0, 1.1), (2, 3)):
        with pytest.raises(ValueError, match="t = 0 to t = 1"):
            ccd.contact_intervals(A, Rest(), B, motion, span)


def test_flights_are_approximated_in_words_too():
    for degree in (0, -1, 1.5, None, "3"):
        with pytest.raises(ValueError, match="degree"):
            ccd.approximate_flight(A, Rest(), degree=degree)
    with pytest.raises(ValueError, match="t_span"):
        ccd.approximate_flight(A, Rest(), (1, 0))
    with pytest.raises(ValueError, match="ellipsoid"):
        ccd.approximate_flight(None, Rest())
    with pytest.raises(ValueError, match="flight"):
        ccd.approximate_flight(A, GOOD)


def test_shrinking_to_nothing_within_the_span_is_refused():
    shrinking = FreeFlight((0, 0, 0), growth_rate=-2.0)
    with pytest.raises(ValueError, match="motion_a"):
        ccd.contact_intervals(A, shrinking, B, GOOD)


def test_extreme_magnitudes_give_an_answer_or_a_refusal():
    """Sizes, paths, quaternions and denominators from 1e-150 to 1e150: no crash, no endless loop, no nan in a time."""
    rng = np.random.default_rng(0)
    told = refused = 0
    for k in range(250):
        a, motion_a = single(rigid(rng, 1, 2, 2, int(rng.integers(0, 2))), 0)
        b, motion_b = single(rigid(rng, 1, 2, 1), 0)
        reach = rng.choice([3, 20, 60, 150])
        factor = 10.0 ** rng.uniform(-reach, reach, 8)
        try:
            a, b = Ellipsoid(a.semi_axes * factor[0] * [1, 1, factor[1] if k % 3 == 0 else 1]), Ellipsoid(b.semi_axes * factor[2])
            motion_a = RationalMotion(motion_a.rotation * factor[3], motion_a.translation * factor[4], motion_a.denominator * factor[5])
            motion_b = RationalMotion(motion_b.rotation * factor[6], motion_b.translation * factor[7])
            found, first = ccd.contact_intervals(a, motion_a, b, motion_b), ccd.first_contact(a, motion_a, b, motion_b)
        except (ValueError, ArithmeticError):
            refused += 1
            continue
        assert (found[0].start, found[-1].end) == (0, 1)
        assert all(i.start <= i.end and not np.isnan(i.start + i.end) for i in found)
        assert not np.isnan(first.time)
        if State.UNRESOLVED not in [i.state for i in found] and first.status != Status.UNRESOLVED and first.time > 0:
            start = next((i.start for i in found if i.state == State.OVERLAPPING), np.inf)
            assert first.time == pytest.approx(start, abs=1e-6)
        told += 1
    assert told > 100
