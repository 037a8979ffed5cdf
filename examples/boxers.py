"""Two boxers of twenty ellipsoids each: when do they first touch between two frames? Sec. 4.1 and Table 1 of the paper.

tau_frm is the CPU time of a frame of 400 pairs; the motions in between are made when a pair first needs them, and are part of it. tau_e,
tau_f and tau_c are means over all pairs, those free of collision and those in collision; tau_w is the worst. A single pair is timed by
asking for it many times at once.
"""

import argparse
import time
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

import ccd
from ccd import scene
from ccd.scene import Outcome
from figures.boxing import NAMES, boxing
from figures.drawing import moved, save_row
from figures.drawing import scene as picture

SETUPS = {"rigid motion, setup 1": {"interpolant": "rigid"},            # spheres, planes, the earliest contact as a bound
          "rigid motion, setup 2": {"interpolant": "rigid", "planes": False, "running_bound": False},
          "affine motion, setup 2": {"interpolant": "affine", "running_bound": False}}
CULLING = {"interpolant": "rigid", "running_bound": False}
FREE = (Outcome.SPHERES_APART, Outcome.PLANE_HOLDS, Outcome.NO_CONTACT)
COLLIDING, CLOSE = (Outcome.OVERLAPPING, Outcome.CONTACT), (Outcome.NO_CONTACT, Outcome.CONTACT, Outcome.UNRESOLVED)
COPIES = 100                # of a pair, when it is timed
TIMED = 150                 # pairs of each kind at most
ROUNDS = 3
SKIN, TRUNKS = ((0.78, 0.025, 0.055), (0.58, 0.03, 0.045)), ((0.60, -0.03, -0.12), (0.62, -0.11, 0.06))        # OKLab, of both boxers
GLOVES, SHOES = ((0.52, -0.03, -0.15), (0.55, -0.12, 0.07)), ((0.35, 0, 0), (0.93, 0, 0.01))
WORN = {"pelvis": TRUNKS, "thigh": TRUNKS, "glove": GLOVES, "foot": SHOES}
PICTURE, FLOOR_RADIUS = (480, 480), 0.85


class Solved(NamedTuple):
    """All frames in one setup."""

    milliseconds: float         # a frame
    contacts: list              # ccd.scene.FrameContact of every frame

    @property
    def outcomes(self):
        return np.array([contact.outcomes for contact in self.contacts])

    @property
    def times(self):
        return np.array([contact.times for contact in self.contacts])


def frames(boxer):
    """The boxer between each frame and the next."""
    poses = [ccd.Bodies(boxer.semi_axes, *pose) for pose in zip(boxer.center, boxer.orientation)]
    return [scene.Group(*ends) for ends in pairwise(poses)]


def solved(groups, setup):
    """Every frame in this setup, and the mean CPU time of one: the best of a few rounds."""
    best = float("inf")
    for _ in range(ROUNDS):
        began = time.process_time()
        contacts = [scene.first_contact(a, b, **setup) for a, b in groups]
        best = min(best, time.process_time() - began)
    return Solved(1e3 * best / len(groups), contacts)


def microseconds(groups, pair, setup):
    """CPU time of one pair (frame, i, j) over its whole frame."""
    frame, i, j = pair
    a, b = (scene.Group(*(ccd.Bodies(end.semi_axes[rows], end.center[rows], end.orientation[rows]) for end in (group.start, group.end)))
            for group, rows in zip(groups[frame], ([i], [j] * COPIES)))
    return 1e3 * solved([(a, b)], setup | {"running_bound": False}).milliseconds / COPIES


class Times(NamedTuple):
    """CPU times of single pairs of one kind (Outcome), in microseconds: how many there are, and the times of some of them."""

    number: int
    some: list


def times_by_kind(groups, outcomes, setup):
    """Times of pairs of every kind."""
    table = {}
    for kind in Outcome:
        pairs = np.argwhere(outcomes == kind)
        chosen = np.unique(np.linspace(0, len(pairs) - 1, TIMED).round().astype(int)) if len(pairs) else []
        table[kind] = Times(len(pairs), [microseconds(groups, pairs[k], setup) for k in chosen])
    return table


def mean(table, *kinds):
    """The mean time over all pairs of these kinds; nan for none."""
    there = [table[kind] for kind in kinds if table[kind].number]
    return sum(each.number * np.mean(each.some) for each in there) / sum(each.number for each in there) if there else np.nan


def worst(table, *kinds):
    """The longest time of these kinds."""
    return max((time for kind in kinds for time in table[kind].some), default=np.nan)


def print_table(groups, outcomes, runs):
    print(f"{'':28}tau_frm (ms)  tau_e (us)  tau_f (us)  tau_c (us)  tau_w (us)")
    for name, run in runs.items():
        table = times_by_kind(groups, outcomes, SETUPS[name])
        print(f"{name:28}{run.milliseconds:12.3f}  {1e3 * run.milliseconds / outcomes[0].size:10.2f}  {mean(table, *FREE):10.2f}"
              f"  {mean(table, *COLLIDING):10.2f}  {worst(table, *Outcome):10.2f}")
        print(f"{'  over close pairs':40}  {mean(table, *CLOSE):10.2f}  {mean(table, Outcome.NO_CONTACT):10.2f}"
              f"  {mean(table, Outcome.CONTACT):10.2f}  {worst(table, *CLOSE):10.2f}")


def print_culling(outcomes):
    number = {kind: int((outcomes == kind).sum()) for kind in Outcome}
    met = max(outcomes.size - number[Outcome.SPHERES_APART], 1)
    close = sum(number[kind] for kind in CLOSE)
    print(f"{outcomes.size} pairs in {len(outcomes)} frames: {number[Outcome.SPHERES_APART] / outcomes.size:.1%} removed by the spheres;\n"
          f"of the rest {number[Outcome.OVERLAPPING] / met:.1%} overlap when their frame starts,"
          f" {number[Outcome.PLANE_HOLDS] / met:.1%} are kept apart by a plane;\n"
          f"{close} close pairs are left, of which {number[Outcome.CONTACT]} touch.")


def print_deviation(rigid, affine):
    differ = np.isin(rigid.outcomes, COLLIDING) != np.isin(affine.outcomes, COLLIDING)
    both = (rigid.outcomes == Outcome.CONTACT) & (affine.outcomes == Outcome.CONTACT)
    apart = np.abs(rigid.times[both] - affine.times[both]) if both.any() else np.array([np.nan])
    print(f"contact times of {both.sum()} pairs, affine against rigid motion: mean difference {apart.mean():.4f}, standard deviation"
          f" {apart.std():.4f},\nmaximum {apart.max():.4f} (in frames); {differ.sum()} pairs collide under one of the two only.")


def hit(outcomes):
    """A pair (frame, i, j) that touches: a glove and a head, if any do, in the frame with the fewest overlaps; None if nothing touches."""
    contacts = np.argwhere(outcomes == Outcome.CONTACT)
    punches = [pair for pair in contacts if {NAMES[k].split()[-1] for k in pair[1:]} == {"glove", "head"}]
    overlaps = (outcomes == Outcome.OVERLAPPING).sum(axis=(1, 2))
    return min(punches or contacts, key=lambda pair: overlaps[pair[0]], default=None)


def ellipsoids(bodies):
    """One by one."""
    return [ccd.Ellipsoid(*each) for each in zip(bodies.semi_axes, bodies.center, bodies.orientation)]


def draw(group_a, group_b, when, times, path):
    """Both boxers at one time of a frame; red: what touches then or has touched before, by the contact times (20, 20) of the pairs."""
    starts, ends = ellipsoids(group_a.start) + ellipsoids(group_b.start), ellipsoids(group_a.end) + ellipsoids(group_b.end)
    bodies = moved(starts, [ccd.interpolate_rigid(*poses) for poses in zip(starts, ends)], when)
    i, j = np.nonzero(times <= when)
    colours = [WORN.get(name.split()[-1], SKIN)[corner] for corner in (0, 1) for name in NAMES]
    middle, across = (bodies[0][:len(NAMES)].mean(axis=0) + sign * bodies[0][len(NAMES):].mean(axis=0) for sign in (1, -1))
    view = np.array([-across[1], across[0], 0]) / np.hypot(*across[:2]) + 0.25 * across / np.linalg.norm(across) + [0, 0, 0.22]
    floor = (*middle[:2] / 2, 0, FLOOR_RADIUS)
    save_row([picture(bodies, colours, {*i, *(len(NAMES) + j)}, view, PICTURE, floor)], path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--folder", type=Path, default=Path("boxers"), help="where the picture goes")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    groups = list(zip(*(frames(boxer) for boxer in boxing(options.frames + 1))))
    runs = {name: solved(groups, setup) for name, setup in SETUPS.items()}
    outcomes = solved(groups, CULLING).outcomes
    print_culling(outcomes)
    print()
    print_table(groups, outcomes, runs)
    _, rigid, affine = runs.values()
    print()
    print_deviation(rigid, affine)
    if (pair := hit(outcomes)) is not None:
        frame, i, j = pair
        draw(*groups[frame], rigid.times[frame, i, j], rigid.times[frame], options.folder / "boxers.png")
        print(f"\npicture  {options.folder / 'boxers.png'}   (frame {frame}, {NAMES[i]} against {NAMES[j]})")


if __name__ == "__main__":
    main()
