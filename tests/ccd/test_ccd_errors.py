"""Bad input is refused in words: ValueError that names the argument, and nothing is half done."""

import numpy as np
import pytest

import ccd
from ccd import AffineEllipsoid, Bodies, Ellipsoid, FreeFlight, Rest
from ccd.contacts import contact_functions, contact_pairs

NAN, INF = float("nan"), float("inf")
UNIT = (1, 0, 0, 0)
A, B = Ellipsoid((1, 1, 1)), Ellipsoid((1, 2, 3), (9, 0, 0))


@pytest.mark.parametrize("wrong", [(1, 2), (1, 2, 3, 4), 1.0, (0, 1, 1), (1, -1, 1), (1, 1, NAN), (1, 1, INF), "abc", None, ((1, 2, 3),),
                                   (1, 2, 3j), [1, 2, "x"]])
def test_semi_axes_are_three_positive_lengths(wrong):
    with pytest.raises(ValueError, match="semi_axes"):
        Ellipsoid(wrong)


@pytest.mark.parametrize("wrong", [(1, 2), 0.0, (1, 2, NAN), (1, 2, -INF), "abc", None, np.zeros((1, 3))])
def test_center_is_three_finite_coordinates(wrong):
    with pytest.raises(ValueError, match="center"):
        Ellipsoid((1, 1, 1), wrong)


@pytest.mark.parametrize("wrong", [(1, 0, 0), (0, 0, 0, 0), (1, 0, 0, NAN), (INF, 0, 0, 0), "abc", None, np.eye(3)])
def test_orientation_is_a_quaternion_that_is_not_zero(wrong):
    with pytest.raises(ValueError, match="orientation"):
        Ellipsoid((1, 1, 1), (0, 0, 0), wrong)


@pytest.mark.parametrize("wrong", [0, -1, NAN, INF, "heavy", None])
def test_mass_is_positive(wrong):
    with pytest.raises(ValueError, match="mass"):
        A.inertia(wrong)


@pytest.mark.parametrize(("name", "wrong"), [
    *[("velocity", wrong) for wrong in ((1, 2), 1.0, (1, 2, NAN), "fast", None)],
    *[("angular_velocity", wrong) for wrong in ((1, 2), 1.0, (INF, 0, 0), None)],
    *[("growth_rate", wrong) for wrong in (NAN, INF, "quick", None, (1, 2))],
])
def test_a_flight_is_finite(name, wrong):
    with pytest.raises(ValueError, match=name):
        FreeFlight(**({"velocity": (0, 0, 0)} | {name: wrong}))


@pytest.mark.parametrize("wrong", [None, (1, 1, 1), 3, Rest()])
def test_separation_takes_ellipsoids(wrong):
    with pytest.raises(ValueError, match=r"^a = "):
        ccd.separation(wrong, B)
    with pytest.raises(ValueError, match=r"^b = "):
        ccd.separation(A, wrong)


@pytest.mark.parametrize("question", [ccd.state, ccd.contact_point, ccd.characteristic_polynomial])
@pytest.mark.parametrize("wrong", [None, (1, 1, 1), 3, Rest()])
def test_the_questions_of_section_2_take_ellipsoids(question, wrong):
    with pytest.raises(ValueError, match=r"^a = .*AffineEllipsoid"):
        question(wrong, B)
    with pytest.raises(ValueError, match=r"^b = .*AffineEllipsoid"):
        question(A, wrong)


@pytest.mark.parametrize(("a", "b"), [(A, B), (A, Ellipsoid((1, 2, 3))), (A, A), (AffineEllipsoid((1, 1, 1), np.eye(3)), B)])
def test_only_touching_pairs_have_a_contact_point(a, b):
    with pytest.raises(ValueError, match=r"contact function is [\d.]+, expected 1 to within 1e-06"):
        ccd.contact_point(a, b)


def test_sizes_too_different_for_float64_are_told_and_not_guessed():
    a, b = Ellipsoid((1, 2, 3)), Ellipsoid((3e120, 2e120, 1e120), (2e120, 1e120, 1.1e120), (1, 0.2, 0.3, 0))
    for question in (ccd.state, ccd.separation, ccd.contact_point):
        with pytest.raises(ArithmeticError, match="double precision"):
            question(a, b)
    near, far = (Bodies(*(np.array([x, y]) for x, y in zip(*((body.semi_axes, body.center, body.orientation) for body in pair))))
                 for pair in ((A, a), (B, b)))
    with pytest.raises(ArithmeticError, match=r"pair 1.*double precision"):
        ccd.batch.state(near, far)
    assert np.isnan(ccd.batch.contact_function(near, far)).tolist() == [False, True]


@pytest.mark.parametrize("wrong", [np.zeros((3, 3)), np.ones((3, 3)), [[1, 2, 3], [4, 5, 6], [7, 8, 9]], np.diag([1, 1, 1e-17])])
def test_a_linear_map_must_not_be_singular(wrong):
    with pytest.raises(ValueError, match=r"^linear = .*singular"):
        AffineEllipsoid((1, 1, 1), wrong)


@pytest.mark.parametrize(("name", "wrong"), [
    *[("linear", wrong) for wrong in (np.eye(4), (1, 1, 1), np.full((3, 3), NAN), 1.0, "abc", None)],
    *[("translation", wrong) for wrong in ((1, 2), (1, 2, INF), None)],
    *[("semi_axes", wrong) for wrong in ((1, 2), (1, 2, 0), (1, 2, NAN), None)],
])
def test_an_affine_pose_is_a_matrix_and_a_vector(name, wrong):
    with pytest.raises(ValueError, match=name):
        AffineEllipsoid(**({"semi_axes": (1, 1, 1), "linear": np.eye(3)} | {name: wrong}))


@pytest.mark.parametrize("wrong", [None, (1, 1, 1), A])
def test_first_contact_takes_motions(wrong):
    with pytest.raises(ValueError, match="motion_a"):
        ccd.first_contact(A, wrong, B, Rest())
    with pytest.raises(ValueError, match="motion_b"):
        ccd.first_contact(A, Rest(), B, wrong)


@pytest.mark.parametrize("wrong", [None, (1, 1, 1), 3])
def test_first_contact_takes_ellipsoids(wrong):
    with pytest.raises(ValueError, match=r"^a = "):
        ccd.first_contact(wrong, Rest(), B, Rest())
    with pytest.raises(ValueError, match=r"^b = "):
        ccd.first_contact(A, Rest(), wrong, Rest())


@pytest.mark.parametrize("wrong", [(1, 0), (1, 1), (0, NAN), (0, INF), (-INF, 0), ("a", "b"), (0, 1, 2), (0,), 1.0, None])
def test_a_window_is_two_finite_times_in_order(wrong):
    with pytest.raises(ValueError, match="t_span"):
        ccd.first_contact(A, Rest(), B, Rest(), wrong)


@pytest.mark.parametrize(("rate", "window"), [(-1.0, (0, 1)), (-0.5, (0, 3)), (0.5, (-3, 1))])
def test_bodies_must_not_vanish_within_the_window(rate, window):
    with pytest.raises(ValueError, match=r"motion_b\.growth_rate"):
        ccd.first_contact(A, Rest(), B, FreeFlight((0, 0, 0), growth_rate=rate), window)


@pytest.mark.parametrize(("name", "wrong"), [
    ("semi_axes", np.ones((3, 3))), ("semi_axes", -np.ones((2, 3))), ("semi_axes", (1, 1)), ("center", np.zeros(3)),
    ("center", np.full((2, 3), NAN)), ("orientation", np.zeros((2, 4))), ("orientation", np.ones((3, 4))), ("orientation", np.ones(4)),
    ("velocity", np.zeros((3, 3))), ("velocity", np.zeros(3)), ("angular_velocity", np.full((2, 3), INF)),
    ("growth_rate", np.zeros(3)), ("growth_rate", NAN), ("growth_rate", "quick"),
])
def test_arrays_of_bodies_have_one_row_each(name, wrong):
    good = {"semi_axes": np.ones((2, 3)), "center": np.zeros((2, 3)), "orientation": np.tile(UNIT, (2, 1))}
    with pytest.raises(ValueError, match=name):
        Bodies(**(good | {name: wrong}))


@pytest.fixture
def two():
    return Bodies((1, 1, 1), np.zeros((2, 3)), np.tile(UNIT, (2, 1)))


@pytest.fixture
def three():
    return Bodies((1, 1, 1), np.full((3, 3), 5.0), np.tile(UNIT, (3, 1)))


def test_batches_are_of_one_length(two, three):
    for question in (ccd.batch.first_contact, ccd.batch.contact_function, ccd.batch.state):
        with pytest.raises(ValueError, match="bodies_b"):
            question(two, three)


@pytest.mark.parametrize("wrong", [0, -1, NAN, INF, "soon", None])
def test_a_batch_ends_at_a_positive_time(two, wrong):
    with pytest.raises(ValueError, match="t_max"):
        ccd.batch.first_contact(two, two, wrong)


def test_no_body_of_a_batch_may_vanish(three):
    shrinking = Bodies((1, 1, 1), np.zeros((3, 3)), np.tile(UNIT, (3, 1)), growth_rate=[0, -0.6, 0])
    with pytest.raises(ValueError, match=r"bodies_b\.growth_rate"):
        ccd.batch.first_contact(three, shrinking, 2.0)
    ccd.batch.first_contact(three, shrinking, 1.0)


@pytest.mark.parametrize("wrong", [None, A, np.zeros((2, 3))])
def test_a_batch_takes_bodies(two, wrong):
    with pytest.raises(ValueError, match="bodies_a"):
        ccd.batch.first_contact(wrong, two)
    for question in (ccd.batch.contact_function, ccd.batch.state):
        with pytest.raises(ValueError, match="bodies_b"):
            question(two, wrong)


@pytest.mark.parametrize(("name", "wrong"), [
    ("positions", np.zeros(3)), ("positions", np.full((2, 3), NAN)), ("orientations", np.ones((3, 4))), ("semi_axes", np.ones((3, 3))),
    ("semi_axes", np.zeros((2, 3))), ("cell", np.ones(3)), ("cell", np.ones((3, 3))), ("cell", np.full((3, 3), INF)),
    ("gap", -1.0), ("gap", NAN),
])
def test_contacts_among_many_bodies(name, wrong):
    good = {"positions": np.zeros((2, 3)), "orientations": np.tile(UNIT, (2, 1)), "semi_axes": np.ones((2, 3)), "cell": 5 * np.eye(3)}
    for question in (contact_functions, contact_pairs):
        with pytest.raises(ValueError, match=name):
            question(**(good | {name: wrong}))


def test_affine_bodies_are_checked_too():
    eye, nowhere = np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 3))
    with pytest.raises(ValueError, match=r"linear.*singular"):
        ccd.AffineBodies((1, 1, 1), np.stack([np.eye(3), np.diag([1, 1, 0])]), nowhere)
    with pytest.raises(ValueError, match="linear has shape"):
        ccd.AffineBodies((1, 1, 1), np.eye(3), nowhere)
    affine = ccd.AffineBodies((1, 1, 1), eye, nowhere)
    with pytest.raises(ValueError, match="bodies_b is Bodies: expected AffineBodies"):
        ccd.batch.state(affine, Bodies((1, 1, 1), nowhere, np.tile(UNIT, (2, 1))))
    with pytest.raises(ValueError, match=r"(?s)bodies_a = .*expected ccd\.Bodies$"):
        ccd.batch.first_contact(affine, affine)
