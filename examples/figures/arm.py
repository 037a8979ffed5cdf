"""A robot arm of ten ellipsoids and an I-shaped obstacle of three, after Sec. 4.2 of the paper.

An arm in the manner of a CRS F3: the waist turns about the vertical, shoulder and elbow about horizontal axes, the wrist is held. Lengths
are metres, z is up. A joint's Euler parameters are linear in t, its rotation matrix has degree 2; a link behind k joints has rotations
and translations of degree 2 k, composed exactly.

A polynomial is an array whose last axis holds its coefficients, in the power basis.
"""

from typing import NamedTuple

import numpy as np

import ccd


class Joint(NamedTuple):
    """A joint turns from one angle (degrees) to another about an axis of the link before, in which it sits at `position`."""

    position: tuple
    axis: tuple
    start: float
    end: float

    @property
    def quaternion(self):
        """Euler parameters (4, 2), linear in t."""
        ends = [np.concatenate([[np.cos(half)], np.multiply(np.sin(half), self.axis)]) for half in np.radians([self.start, self.end]) / 2]
        return np.column_stack([ends[0], ends[1] - ends[0]])


class Link(NamedTuple):
    """An ellipsoid behind so many joints, along the axes of the last joint's frame."""

    joints: int
    center: tuple
    semi_axes: tuple


WAIST = Joint((0, 0, 0), (0, 0, 1), -50, 55)
SHOULDER = Joint((0.10, 0, 0.35), (0, 1, 0), 10, 50)
ELBOW = Joint((0, 0, 0.265), (0, 1, 0), 95, 35)
JOINTS = (WAIST, SHOULDER, ELBOW)
LINKS = (
    Link(0, (0, 0, 0.10), (0.13, 0.13, 0.12)),              # 0: base
    Link(1, (0, 0, 0.25), (0.095, 0.095, 0.10)),            # 1 to 3: turret, shoulder, motor
    Link(1, (0.07, 0, 0.35), (0.085, 0.12, 0.075)),
    Link(1, (-0.07, 0, 0.33), (0.10, 0.06, 0.06)),
    Link(2, (0, 0, 0.12), (0.055, 0.065, 0.17)),            # 4, 5: upper arm, elbow
    Link(2, (0, 0, 0.26), (0.06, 0.095, 0.06)),
    Link(3, (0, 0, 0.13), (0.045, 0.05, 0.17)),             # 6 to 9: forearm, hand, fingers
    Link(3, (0, 0, 0.31), (0.065, 0.045, 0.055)),
    Link(3, (-0.035, 0, 0.40), (0.014, 0.018, 0.06)),
    Link(3, (0.035, 0, 0.40), (0.014, 0.018, 0.06)),
)
OBSTACLES = {
    "U": ccd.Ellipsoid((0.09, 0.36, 0.03), (0.42, 0.03, 0.03)),
    "V": ccd.Ellipsoid((0.035, 0.18, 0.24), (0.42, 0.03, 0.25)),
    "W": ccd.Ellipsoid((0.05, 0.36, 0.03), (0.42, 0.03, 0.50)),
}


def product(p, q):
    """Hamilton product (4, m + n + 1) of quaternion polynomials (4, m + 1) and (4, n + 1)."""
    (a, b, c, d), times = p, np.convolve
    e, f, g, h = q
    return np.array([times(a, e) - times(b, f) - times(c, g) - times(d, h), times(a, f) + times(b, e) + times(c, h) - times(d, g),
                     times(a, g) - times(b, h) + times(c, e) + times(d, f), times(a, h) + times(b, g) - times(c, f) + times(d, e)])


def turned(q, point):
    """A point turned by a quaternion polynomial (4, k + 1) and stretched by its norm: (3, 2 k + 1)."""
    conjugate = q * np.array([[1], [-1], [-1], [-1]])
    return product(product(q, np.concatenate([[0], point])[:, None]), conjugate)[1:]


def norm(q):
    """The squared norm E (2 k + 1,) of a quaternion polynomial (4, k + 1)."""
    return sum(np.convolve(component, component) for component in q)


def motion(link):
    """The ccd.RationalMotion of a link (ccd.Rest for one before all joints, where its Ellipsoid stands)."""
    if link.joints == 0:
        return ccd.Rest()
    rotation, position, denominator = np.array([[1.0], [0], [0], [0]]), np.zeros((3, 1)), np.ones(1)
    for joint in JOINTS[: link.joints]:
        E = norm(joint.quaternion)
        position = [np.convolve(component, E) for component in position + turned(rotation, joint.position)]
        position, rotation, denominator = np.array(position), product(rotation, joint.quaternion), np.convolve(denominator, E)
    return ccd.RationalMotion(rotation, position + turned(rotation, link.center), denominator)


def ellipsoid(link):
    """The Ellipsoid of a link; only before all joints does its centre count."""
    return ccd.Ellipsoid(link.semi_axes, link.center if link.joints == 0 else (0, 0, 0))


def pairs():
    """The 30 pairs of the paper's Table 2: ((name of the obstacle, number of the link), (obstacle, its motion, link, its motion))."""
    links = [(ellipsoid(link), motion(link)) for link in LINKS]
    return [((name, k), (obstacle, ccd.Rest(), *link)) for name, obstacle in OBSTACLES.items() for k, link in enumerate(links)]
