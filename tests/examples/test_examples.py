"""The examples: the figures of the paper's move as they promise, each runs and leaves its files."""

import re
import sys

import numpy as np
import pytest
from dense import contact_function_and_normal
from numpy.polynomial.polynomial import polyval
from scipy.spatial.transform import Rotation

import boxers
import ccd
import ccd_equation
import contacts_of_a_frame
import cooling
import crystal_from_ase
import equation_of_state
import isotropic_to_nematic
import packing_by_aspect_ratio
import robot_arm
import sweep_compression_rates
from figures import arm, boxing

TIMES = np.array([0.0, 0.137, 0.5, 0.731, 1.0])


# independent of ccd

def rational(numerator, times, denominator=(1.0,)):
    """Rational functions with power-basis coefficients (..., k + 1) at all times (T,): (T, ...)."""
    over = polyval(times, np.asarray(denominator, dtype=float))
    return np.moveaxis(polyval(times, np.moveaxis(np.asarray(numerator, dtype=float), -1, 0)) / over, -1, 0)


def lab_poses(ellipsoid, motion, times):
    """Centres (T, 3) and semi-axis vectors (T, 3, 3), as columns."""
    if isinstance(motion, ccd.RationalMotion):
        turns = Rotation.from_quat(np.roll(rational(motion.rotation, times), -1, axis=1)).as_matrix()
        return rational(motion.translation, times, motion.denominator), turns * ellipsoid.semi_axes
    if isinstance(motion, ccd.AffineMotion):
        return (rational(motion.translation, times, motion.denominator),
                rational(motion.linear, times, motion.denominator) * ellipsoid.semi_axes)
    return np.tile(ellipsoid.center, (len(times), 1)), np.tile(np.diag(ellipsoid.semi_axes), (len(times), 1, 1))


def excess(pair, times):
    """The contact function minus 1 at all times."""
    a, motion_a, b, motion_b = pair
    (centers_a, axes_a), (centers_b, axes_b) = lab_poses(a, motion_a, times), lab_poses(b, motion_b, times)
    return contact_function_and_normal(centers_b - centers_a, axes_a, axes_b)[0] - 1


def overlaps_by_sampling(pair, samples):
    """Ends of the overlapping intervals within (0, 1), by looking at many times and halving."""
    times = np.linspace(0, 1, samples)
    value = excess(pair, times)
    crossed = np.flatnonzero(value[1:] * value[:-1] < 0)
    low, high, sign = times[crossed], times[crossed + 1], np.sign(value[crossed])
    for _ in range(40 if len(crossed) else 0):
        middle = 0.5 * (low + high)
        before = np.sign(excess(pair, middle)) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return 0.5 * (low + high)


def ends(intervals):
    return [end for each in intervals if each.state == ccd.State.OVERLAPPING for end in (each.start, each.end)]


# the boxers

@pytest.fixture(scope="module")
def fight():
    return boxing.boxing(1000)


def test_two_boxers_of_twenty_ellipsoids(fight):
    for boxer in fight:
        assert boxer.semi_axes.shape == (20, 3)
        assert boxer.center.shape == (1000, 20, 3)
        assert boxer.orientation.shape == (1000, 20, 4)
        np.testing.assert_allclose(np.linalg.norm(boxer.orientation, axis=2), 1, atol=1e-14)


def test_no_quaternion_jumps_and_no_part_leaps(fight):
    for boxer in fight:
        assert (np.einsum("fpk,fpk->fp", boxer.orientation[1:], boxer.orientation[:-1]) > 0.98).all()
        assert np.linalg.norm(np.diff(boxer.center, axis=0), axis=2).max() < 0.15


def test_limbs_stay_in_their_joints(fight):
    for boxer in fight:
        for side in ("left", "right"):
            for first, second, lengths in (("upper arm", "forearm", boxing.ARM), ("thigh", "shin", boxing.LEG)):
                joint = [point_on_limb(boxer, f"{side} {name}", along) for name, along in ((first, lengths[0]), (second, 0.0))]
                np.testing.assert_allclose(*joint, atol=1e-12)


def point_on_limb(boxer, name, along):
    """The point of the limb's bone at this distance from its upper joint, in all frames (frames, 3)."""
    k = boxing.NAMES.index(name)
    turn = Rotation.from_quat(np.roll(boxer.orientation[:, k], -1, axis=1))
    return boxer.center[:, k] + turn.apply([0, 0, along - boxing.PARTS[name].center[2]])


def test_the_feet_stay_on_the_floor(fight):
    feet = [boxing.NAMES.index(f"{side} foot") for side in ("left", "right")]
    for boxer in fight:
        height = boxer.center[:, feet, 2] - boxer.semi_axes[feet, 2]
        assert height.min() > -0.01
        assert height.max() < 0.06


def test_a_short_fight_is_the_beginning_of_a_long_one(fight):
    for boxer, same in zip(fight, boxing.boxing(40)):
        np.testing.assert_allclose(boxer.center[:40], same.center, atol=1e-14)
        np.testing.assert_allclose(boxer.orientation[:40], same.orientation, atol=1e-14)


# the arm

def homogeneous(joint, t):
    """The joint's matrix (4, 4), from its angles alone."""
    start, end = np.radians([joint.start, joint.end]) / 2
    half = np.arctan2((1 - t) * np.sin(start) + t * np.sin(end), (1 - t) * np.cos(start) + t * np.cos(end))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_rotvec(2 * half * np.array(joint.axis)).as_matrix(), joint.position
    return matrix


def test_links_move_with_their_joints():
    for link in arm.LINKS:
        for t, center, axes in zip(TIMES, *lab_poses(arm.ellipsoid(link), arm.motion(link), TIMES)):
            pose = np.eye(4)
            for joint in arm.JOINTS[:link.joints]:
                pose = pose @ homogeneous(joint, t)
            np.testing.assert_allclose(center, (pose @ [*link.center, 1])[:3], atol=1e-13)
            np.testing.assert_allclose(axes, pose[:3, :3] * link.semi_axes, atol=1e-13)


def test_degrees_of_the_arm_are_those_of_the_paper():
    assert [getattr(arm.motion(link), "degree", 0) for link in arm.LINKS] == [0, 2, 2, 2, 4, 4, 6, 6, 6, 6]


def test_joints_turn_from_angle_to_angle():
    for joint in arm.JOINTS:
        turns = [Rotation.from_quat(np.roll(joint.quaternion @ [1, t], -1)).as_rotvec() for t in (0, 1)]
        np.testing.assert_allclose(turns, np.radians([[joint.start], [joint.end]]) * np.array(joint.axis), atol=1e-14)


def test_three_pairs_of_thirty_collide_and_one_of_them_twice():
    intervals = {names: ccd.contact_intervals(*pair) for names, pair in arm.pairs()}
    assert len(intervals) == 30
    assert {each.state for found in intervals.values() for each in found} == {ccd.State.SEPARATE, ccd.State.OVERLAPPING}
    assert {names: len(ends(found)) // 2 for names, found in intervals.items() if ends(found)} == {("W", 6): 1, ("W", 7): 2, ("W", 9): 1}
    for names, pair in arm.pairs():
        np.testing.assert_allclose(ends(intervals[names]), overlaps_by_sampling(pair, 101), rtol=0, atol=1e-10)


# the CCD equation

@pytest.mark.parametrize("t", TIMES)
def test_example_1_moves_as_the_paper_prints_it(t):
    _, motion_a, _, motion_b = ccd_equation.example_1()
    root2 = np.sqrt(2)
    turn_a = np.array([[-(8*t**2 - 8*t + 1), -2*(2*t - 1), 2*(2*t - 1)], [2*(2*t - 1), 1, 2*(2*t - 1)**2],
                       [-2*(2*t - 1), 2*(2*t - 1)**2, 1]]) / (8*t**2 - 8*t + 3)
    turn_b = np.array([[root2*(t - 1)*(3*t - 1), 2*t*(2*t - 1), root2*(t - 1)**2], [root2*(2*t - 1), -2*t*(t - 1), root2*(2*t - 1)**2],
                       [-root2*t*(3*t - 2), 2*(2*t - 1)*(t - 1), root2*t**2]]) / (-2*(3*t**2 - 3*t + 1))
    path_a = [-8*t**3 + 24*t**2 - 6*t - 2, -24*t**3 + 24*t**2 + 6*t - 6, -32*t**3 + 48*t**2 - 12*t - 2]
    path_b = [(72 - 24*root2)*t**3 + (-156 + 72*root2)*t**2 + (114 - 72*root2)*t - 27 + 24*root2, 12*t - 6,
              (88 - 24*root2)*t**3 + (-168 + 72*root2)*t**2 + (114 - 72*root2)*t - 26 + 24*root2]
    for motion, turn, path in ((motion_a, turn_a, path_a), (motion_b, turn_b, path_b)):
        centers, axes = lab_poses(ccd.Ellipsoid((1, 1, 1)), motion, np.array([t]))
        np.testing.assert_allclose(axes[0], turn, atol=1e-14)
        np.testing.assert_allclose(centers[0], path, atol=1e-13)


def test_example_2_overlaps_four_times_under_motions_of_degree_4():
    pair = ccd_equation.example_2()
    assert (pair[1].degree, pair[3].degree) == (4, 4)
    found = ends(ccd.contact_intervals(*pair))
    assert len(found) == 8
    np.testing.assert_allclose(found, overlaps_by_sampling(pair, 401), rtol=0, atol=1e-10)


def test_shoots_stop_at_the_first_contact():
    equation = ccd.CCDEquation(*ccd_equation.example_1())
    steps = ccd_equation.recursive_shoots(equation, 0.0, 1.0)
    errors = [abs(0.5 - reached) for *_, reached in steps[:3]]
    np.testing.assert_allclose(errors[:2], [0.0175, 6.3e-6], rtol=0.02)        # quadratic, Appendix C
    assert errors[2] < 1e-10


# the scripts

@pytest.mark.parametrize(("script", "arguments", "files", "said"), [
    (boxers, ["--frames", "40"], ["boxers.png"], "rigid motion, setup 1"),
    (robot_arm, [], ["robot_arm.png"], "W-7"),
    (ccd_equation, [], ["zero_sets.png", "affine_pair.png"], "Example 2: F has degree"),
    (sweep_compression_rates, ["--replicas", "2"], ["compression_rates.png", "sweep/summary.png"], r"rate 0.1   packing fraction 0\.[67]"),
    (packing_by_aspect_ratio, ["-n", "32", "--rate", "0.1", "--replicas", "2"], ["packing_by_aspect_ratio.png"], r"         1\.5  0\.[67]"),
    (isotropic_to_nematic, ["-n", "32", "--collisions", "20", "--aspect-ratio", "2", "--replicas", "2"], ["isotropic_to_nematic.png"],
     "            0.30   0."),
    (equation_of_state, ["--cells", "3", "--collisions", "20"], ["equation_of_state.png"], "            0.30     "),
    (crystal_from_ase, ["--cells", "2", "--collisions", "20"], ["crystal_from_ase.png"], "32 spheroids from ASE, packing fraction 0.7707"),
    (contacts_of_a_frame, ["-n", "32", "--rate", "0.1"], ["contacts.png"], "contacts between 32 bodies"),
    (cooling, ["-n", "100", "--until", "10"], ["cooling.png"], "Haff's law says"),
], ids=lambda value: getattr(value, "__name__", None))
def test_each_example_runs_and_leaves_its_files(script, arguments, files, said, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(script, "INSTANTS", (0.0, 0.3), raising=False)         # pictures take most of the time
    monkeypatch.setattr("analysis.shading.SKY_LAMPS", 6)
    monkeypatch.setattr(script, "PIXELS", (60, 60), raising=False)
    monkeypatch.setattr(script, "SHAPES", {"ellipsoids": [1.25, 1.0, 0.8]}, raising=False)
    for name, fewer in {"RATES": [0.1], "ASPECT_RATIOS": [0.8, 1.5], "PACKING_FRACTIONS": [0.45, 0.30]}.items():
        if hasattr(script, name):
            rising = getattr(script, name)[0] < getattr(script, name)[-1]
            monkeypatch.setattr(script, name, sorted(fewer) if rising else fewer)
    monkeypatch.setattr(sys, "argv", [script.__name__, "--folder", str(tmp_path / "out"), *arguments])
    script.main()
    assert re.search(said, capsys.readouterr().out)
    for file in files:
        assert (tmp_path / "out" / file).read_bytes().startswith(b"\x89PNG")
