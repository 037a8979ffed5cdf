"""Two boxers of twenty ellipsoids each, after Sec. 4.1 of the paper, whose motion capture data are not available.

Lengths are metres, times seconds; z is up. In a boxer's own frame x points to the opponent and y to the left. Feet, pelvis and gloves
follow smooth paths; knees and elbows follow from them. The fight is written as a score: one letter a beat.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

FRAMES_PER_SECOND = 60
BEAT = 0.42
SCORES = (".j..jc....h.....d..b....j...d.jc....h...",
          "...d....j.....c...j..h.d.....j...d....bj")


class Part(NamedTuple):
    """An ellipsoid and where it sits: centre and semi-axes in the frame of its bone."""

    bone: str
    center: tuple
    semi_axes: tuple


TORSO = {
    "head": Part("head", (0.03, 0, 0.16), (0.10, 0.08, 0.125)),
    "neck": Part("head", (0, 0, 0.02), (0.06, 0.06, 0.08)),
    "chest": Part("chest", (0.01, 0, 0.20), (0.12, 0.18, 0.11)),
    "ribs": Part("chest", (0, 0, 0.08), (0.12, 0.16, 0.13)),
    "belly": Part("spine", (0.01, 0, 0.08), (0.11, 0.145, 0.12)),
    "pelvis": Part("pelvis", (0, 0, 0.02), (0.125, 0.17, 0.12)),
}
LIMBS = {
    "shoulder": Part("upper arm", (0, 0, 0), (0.075, 0.075, 0.08)),
    "upper arm": Part("upper arm", (0, 0, 0.14), (0.055, 0.055, 0.17)),
    "forearm": Part("forearm", (0, 0, 0.11), (0.046, 0.046, 0.15)),
    "glove": Part("forearm", (0, 0, 0.29), (0.075, 0.065, 0.10)),
    "thigh": Part("thigh", (0, 0, 0.20), (0.085, 0.085, 0.25)),
    "shin": Part("shin", (0, 0, 0.20), (0.058, 0.058, 0.24)),
    "foot": Part("foot", (0.05, 0, -0.04), (0.13, 0.048, 0.045)),
}
PARTS = TORSO | {f"{side} {name}": part._replace(bone=f"{side} {part.bone}") for side in ("left", "right") for name, part in LIMBS.items()}
NAMES = tuple(PARTS)

ARM = (0.28, 0.29)          # shoulder to elbow, elbow to the middle of the glove
LEG = (0.42, 0.42)          # hip to knee, knee to ankle
SIDES = {"left": 1.0, "right": -1.0}
STANCE = {"left": (0.17, 0.13, 0.09), "right": (-0.20, -0.13, 0.09)}            # ankles about the middle
GUARD = {"left": (0.34, 0.11, 0.09), "right": (0.26, -0.10, 0.06)}              # gloves about the middle of the shoulders


class Boxer(NamedTuple):
    """Poses at the frames: quaternions are scalar first and never jump in sign from frame to frame."""

    semi_axes: np.ndarray       # (20, 3)
    center: np.ndarray          # (frames, 20, 3)
    orientation: np.ndarray     # (frames, 20, 4)


class Bone(NamedTuple):
    """A frame that moves: where its joint is, and how it is turned."""

    origin: np.ndarray          # (frames, 3)
    rotation: Rotation

    def at(self, point):
        """A point of the bone's frame, in the lab."""
        return self.origin + self.rotation.apply(point)


def boxing(frames=1000):
    """The first frames of the fight. -> two Boxers."""
    time = np.arange(frames) / FRAMES_PER_SECOND
    torsos = [torso(time, corner) for corner in (0, 1)]
    return tuple(posed(torsos[corner] | legs(time, corner, torsos[corner]) | arms(time, corner, torsos[corner], torsos[1 - corner]))
                 for corner in (0, 1))


def posed(bones):
    """The Boxer whose parts hang on these bones."""
    center = np.stack([bones[part.bone].at(part.center) for part in PARTS.values()], axis=1)
    orientation = np.stack([np.roll(bones[part.bone].rotation.as_quat(), 1, axis=1) for part in PARTS.values()], axis=1)
    turned = np.einsum("fpk,fpk->fp", orientation[1:], orientation[:-1]) < 0
    orientation[1:] *= np.where(np.cumsum(turned, axis=0) % 2, -1.0, 1.0)[:, :, None]
    return Boxer(np.array([part.semi_axes for part in PARTS.values()]), center, orientation)


# paths

def range_of(time):
    """Half the distance of the two: from the clinch to out of reach."""
    return 0.44 + 0.13 * np.sin(0.72 * time + 1.0) + 0.02 * np.sin(2.9 * time)


def stand(time, corner):
    """Where a boxer stands: the middle between the feet (frames, 3), and the frame that faces the opponent."""
    heading = 0.25 * time + 0.5 * np.sin(0.4 * time)
    middle = np.column_stack([0.25 * np.sin(0.31 * time), 0.25 * np.sin(0.23 * time + 1), 0 * time])
    facing = euler(heading + np.pi * corner, 0 * time, 0 * time)
    return middle - facing.apply([1, 0, 0]) * range_of(time)[:, None], facing


def pulses(time, corner, letters, half_width):
    """Smooth pulses from 0 to 1 and back on the beats that carry one of these letters."""
    beats = BEAT * np.array([k for k, letter in enumerate(SCORES[corner]) if letter in letters])
    x = np.clip((time[:, None] - beats) / half_width, -1, 1)
    return (np.cos(0.5 * np.pi * x) ** 4).sum(axis=1)


# bones

def torso(time, corner):
    """Pelvis, spine, chest and head: bob and weave, turn into the punches, duck."""
    ground, facing = stand(time, corner)
    duck = pulses(time, corner, "d", 0.55)
    lead, rear = pulses(time, corner, "jh", 0.3), pulses(time, corner, "cb", 0.34)
    low = pulses(time, corner, "b", 0.42)
    sway = np.sin(2.3 * time + 2 * corner)
    height = 0.85 + 0.015 * np.sin(9.5 * time + corner) - 0.17 * duck - 0.08 * low
    origin = ground + facing.apply(np.column_stack([0.06 * (lead + rear), 0.04 * sway, height]))
    pelvis = Bone(origin, facing * euler(-0.45 + 0.30 * rear - 0.10 * lead, 0.10 + 0.20 * duck, 0 * time))
    spine = Bone(pelvis.at((0, 0, 0.09)), pelvis.rotation * euler(0.20 * rear - 0.10 * lead, 0.12 + 0.25 * duck + 0.2 * low, 0.07 * sway))
    chest = Bone(spine.at((0, 0, 0.15)), spine.rotation * euler(0.30 * rear - 0.15 * lead, 0.08 + 0.20 * duck, 0.10 * sway))
    head = Bone(chest.at((0, 0, 0.31)), facing * euler(0 * time, 0.16 + 0.25 * duck, 0.1 * sway))
    return {"pelvis": pelvis, "spine": spine, "chest": chest, "head": head}


def arms(time, corner, own, other):
    """Gloves leave the guard for the opponent's head (or belly) and come back; a hook goes round by the side."""
    _, facing = stand(time, corner)
    strikes = {"left": {"head": pulses(time, corner, "jh", 0.3), "belly": 0 * time, "round": pulses(time, corner, "h", 0.3)},
               "right": {"head": pulses(time, corner, "c", 0.32), "belly": pulses(time, corner, "b", 0.32), "round": 0 * time}}
    targets = {"head": other["head"].at((0.17, 0, 0.13)), "belly": other["spine"].at((0.18, 0, 0.06))}
    closeness = np.column_stack([range_of(time) / 0.60, 1 + 0 * time, 1 + 0 * time])
    bones = {}
    for side, sign in SIDES.items():
        shoulder = own["chest"].at((0, 0.20 * sign, 0.23))
        weave = 0.02 * np.column_stack([np.sin(5.1 * time + sign), np.sin(3.7 * time + corner), np.sin(6.3 * time - sign)])
        glove = own["chest"].at((0, 0, 0.24)) + facing.apply(GUARD[side] * closeness + weave)
        for name, target in targets.items():
            strike = strikes[side][name][:, None]
            glove = glove + strike * (target - glove)
        swing = strikes[side]["round"]
        bulge = 4 * swing * (1 - swing)
        glove = glove + facing.apply(np.column_stack([0 * time, 0.16 * sign * bulge, 0 * time]))
        elbow_side = facing.apply(np.column_stack([-0.2 + 0 * time, sign * (0.4 + 0.6 * swing), -1.0 + 0.2 * swing]))
        bones[f"{side} upper arm"], bones[f"{side} forearm"] = two_bones(shoulder, glove, elbow_side, ARM)
    return bones


def legs(time, corner, own):
    """Feet shuffle: each follows the boxer's path by steps, the two in turn, and lifts a little while it moves."""
    bones = {}
    for side, sign in SIDES.items():
        phase = 2 * np.pi * 1.4 * time + 0.5 * np.pi * sign
        ground, facing = stand(time + np.sin(phase) / (2 * np.pi * 1.4), corner)
        lift = 0.03 * (0.5 + 0.5 * np.cos(phase)) ** 2
        ankle = ground + facing.apply(STANCE[side]) + np.outer(lift, (0, 0, 1))
        hip = own["pelvis"].at((0, 0.095 * sign, -0.02))
        outward = facing.apply((1.0, 0.35 * sign - 0.25, 0))
        bones[f"{side} thigh"], bones[f"{side} shin"] = two_bones(hip, ankle, outward, LEG)
        bones[f"{side} foot"] = Bone(ankle, facing * Rotation.from_euler("z", 0.45 * sign - 0.35))
    return bones


def euler(yaw, pitch, roll):
    """Rotations from angles (frames,): pitch leans forward, roll to the right."""
    return Rotation.from_euler("ZYX", np.column_stack([yaw, pitch, roll]))


def two_bones(start, target, bend, lengths):
    """Two bones in a row that lead from `start` to `target` (a target out of reach is approached), the joint between them towards `bend`.

    Their z axes run along the bones. -> two Bones.
    """
    first, second = lengths
    reach = target - start
    distance = np.linalg.norm(reach, axis=1, keepdims=True)
    along = reach / distance
    distance = distance * (1 + (distance / (0.995 * (first + second))) ** 16) ** (-1 / 16)
    aside = bend - (bend * along).sum(axis=1, keepdims=True) * along
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    shadow = (distance**2 + first**2 - second**2) / (2 * distance)
    joint = start + shadow * along + np.sqrt(first**2 - shadow**2) * aside
    hinge = np.cross(along, aside)
    return Bone(start, along_z(joint - start, hinge)), Bone(joint, along_z(start + distance * along - joint, hinge))


def along_z(direction, hinge):
    """Rotations that take z to a direction and y to the hinge, perpendicular to it (frames, 3)."""
    z = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return Rotation.from_matrix(np.stack([np.cross(hinge, z), hinge, z], axis=2))
