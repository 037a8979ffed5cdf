"""Oracle: how a gas of smooth inelastic spheroids shares its energy between translation and rotation while it cools, at low density.

Direct simulation of the Boltzmann equation (G. A. Bird, Molecular Gas Dynamics, 1994; pairs by rejection, as in his scheme without a time
counter), but two bodies that meet are followed as they fly. Bodies have velocities, spins and axes, no places. In a step each is offered
one other, and the two meet in proportion to their relative speed: anywhere in a uniform beam, the other enters the sphere about the one
outside of which they cannot touch, both turned about their spins by any angles, since their flights before were long. From there they fly,
collide by eq. (26) of docs/theory.md, and fly on until they are out of the sphere: plates that turn into each other again at once collide
again. Such contacts can come ever faster, infinitely many in a finite time: the TC model, eq. (30), makes those lossless that come sooner
than `contact_time` after the pair's last.

numpy, scipy's rotations, the normals of dense.py; of the product `ccd.batch.first_contact` alone, which tests/ccd holds to other oracles.
Nothing of edmd. Approximate are only the number of bodies, the length of a step (a tenth of a contact a body) and the contact time: steps
half as long, or a contact time of 3e-3, left the ratio of plates where it was within 0.002, its error in one run.

Units: masses are 1, bodies uniform solids, lengths as the semi-axes (a, a, c) are given; after each step all speeds are scaled, to an
energy of 5/2 a body, so that both temperatures stay near 1. Bodies never spin about their axes: three degrees of freedom of translation,
two of rotation, T_tr = <v^2> / 3 and T_rot = I <w^2> / 2 with I = (a^2 + c^2) / 5.
"""

import numpy as np
from dense import contact_function_and_normal
from scipy.spatial.transform import Rotation

import ccd

FASTEST = 10.0              # the relative speed that surely meets whom it is offered, in thermal speeds
APART = 1e-12               # how far centres are moved apart at a contact, in units of their distance, lest rounding let bodies overlap

PLATES = {"semi_axes": (1, 1, 1 / 3), "restitution": 0.8}
PLATES_RATIO, PLATES_ERROR = 0.9275, 0.0007     # their T_rot / T_tr, its standard error: runs as in test_oracle_thin_gas.py, seeds 1 to 6


class ThinGas:
    """An even number of spheroids (a, a, c), at first Maxwellian with some T_rot / T_tr. `enter`, `follow` and `collide` take K pairs."""

    def __init__(self, semi_axes, restitution, contact_time, bodies, ratio, seed):
        self.semi_axes, self.restitution, self.contact_time = np.array(semi_axes, dtype=float), restitution, contact_time
        self.moment = (semi_axes[0]**2 + semi_axes[2]**2) / 5
        self.reach = 2 * max(semi_axes)
        self.rng = np.random.default_rng(seed)
        self.axis = _unit(self.rng.normal(size=(bodies, 3)))
        self.velocity = self.rng.normal(size=(bodies, 3))
        self.velocity -= self.velocity.mean(axis=0)
        self.spin = np.sqrt(ratio / self.moment) * np.cross(self.axis, self.rng.normal(size=(bodies, 3)))
        self.encounters = self.contacts = 0

    def temperatures(self):
        """(T_tr, T_rot)."""
        return (self.velocity**2).sum() / (3 * len(self.velocity)), self.moment * (self.spin**2).sum() / (2 * len(self.spin))

    def step(self):
        """Offer every body one other, follow those that meet, and make up for the energy that they lose."""
        one, other = self.rng.permutation(len(self.velocity)).reshape(2, -1)
        speed = np.linalg.norm(self.velocity[other] - self.velocity[one], axis=1)
        if speed.max() > FASTEST:
            raise ArithmeticError(f"a pair at {speed.max():.1f} thermal speeds would meet too seldom")
        meet = self.rng.random(len(one)) * FASTEST < speed
        one, other = one[meet], other[meet]
        self.encounters += len(one)
        self.follow(one, other, self.enter(one, other))
        translation, rotation = self.temperatures()
        faster = np.sqrt(5 / (3 * translation + 2 * rotation))
        self.velocity *= faster
        self.spin *= faster

    def enter(self, one, other):
        """Turn the bodies by any angles; -> where the others enter the spheres about the ones, from the ones' centres."""
        for bodies in (one, other):
            self._turn(bodies, self.rng.uniform(0, 2 * np.pi, len(bodies)) / np.linalg.norm(self.spin[bodies], axis=1))
        towards = _unit(self.velocity[other] - self.velocity[one])
        aside = _unit(np.cross(towards, self.rng.normal(size=towards.shape)))
        miss = self.reach * np.sqrt(self.rng.random((len(one), 1)))
        return miss * aside - np.sqrt(self.reach**2 - miss**2) * towards

    def follow(self, one, other, place):
        """Let the pairs fly and collide until they are out of each other's spheres."""
        first = True
        while len(one):
            time = self._next_contacts(one, other, place)
            meet = np.isfinite(time)
            one, other, place, time = one[meet], other[meet], place[meet], time[meet]
            place = (1 + APART) * (place + (self.velocity[other] - self.velocity[one]) * time[:, None])
            self._turn(one, time)
            self._turn(other, time)
            self.collide(one, other, place, np.where(first | (time >= self.contact_time), self.restitution, 1.0))
            self.contacts += len(one)
            first = False

    def _next_contacts(self, one, other, place):
        """How long until the pairs touch, inf if they leave the spheres before. `ccd.batch` is given flights that all last 1."""
        velocity = self.velocity[other] - self.velocity[one]
        square, outwards = (velocity**2).sum(axis=1), (place * velocity).sum(axis=1)
        leave = (np.sqrt(np.maximum(outwards**2 + square * (self.reach**2 - (place**2).sum(axis=1)), 0)) - outwards) / square
        still, scale = np.zeros_like(place), leave[:, None]
        time, status = ccd.batch.first_contact(*(
            ccd.batch.Bodies(self.semi_axes, center, _quaternions(self.axis[bodies]), scale * motion, scale * self.spin[bodies])
            for bodies, center, motion in ((one, still, still), (other, place, velocity))))
        if ((status != ccd.Status.CONTACT) & (status != ccd.Status.NO_CONTACT)).any():
            raise ArithmeticError(f"pairs that overlap or stay unresolved: {np.bincount(status)} of each status")
        return time * leave

    def collide(self, one, other, place, restitution):
        """Eq. (26) for pairs that touch and approach."""
        shapes = (Rotation.from_quat(_quaternions(self.axis[bodies]), scalar_first=True).as_matrix() * self.semi_axes
                  for bodies in (one, other))
        normal = _unit(contact_function_and_normal(place, *shapes)[1])
        arm, other_arm = (np.cross(self._lever(bodies, outward), normal) for bodies, outward in ((one, normal), (other, -normal)))
        apart = (((self.velocity[other] - self.velocity[one]) * normal).sum(axis=1)
                 + (self.spin[other] * other_arm).sum(axis=1) - (self.spin[one] * arm).sum(axis=1))
        if (apart > 1e-9).any():
            raise ArithmeticError(f"bodies that touch move apart, at {apart.max():.1e} thermal speeds")
        inverse_mass = 2 + ((arm**2).sum(axis=1) + (other_arm**2).sum(axis=1)) / self.moment
        impulse = (-(1 + restitution) * apart / inverse_mass)[:, None]
        self.velocity[one] -= impulse * normal
        self.velocity[other] += impulse * normal
        self.spin[one] -= impulse * arm / self.moment
        self.spin[other] += impulse * other_arm / self.moment

    def _lever(self, bodies, outward):
        """From the centres to where the surfaces have these outward normals."""
        a, c = self.semi_axes[[0, 2]]
        axis = self.axis[bodies]
        stretched = a**2 * outward + (c**2 - a**2) * (axis * outward).sum(axis=1)[:, None] * axis
        return stretched / np.sqrt((stretched * outward).sum(axis=1))[:, None]

    def _turn(self, bodies, time):
        """Free flight of the axes: the spin is constant, and across the axis."""
        spin, axis = self.spin[bodies], self.axis[bodies]
        speed = np.linalg.norm(spin, axis=1)[:, None]
        angle = speed * time[:, None]
        self.axis[bodies] = _unit(np.cos(angle) * axis + np.sin(angle) * np.cross(spin / speed, axis))


def cooling_ratios(semi_axes, restitution, *, contact_time=1e-2, bodies, settling, blocks, contacts, seed):
    """T_rot / T_tr of the homogeneous cooling state: means (blocks,) over so many contacts a body each, after those of settling."""
    gas = ThinGas(semi_axes, restitution, contact_time, bodies, 1.0, seed)
    means = []
    for length in [settling] + blocks * [contacts]:
        seen, end = [], gas.contacts + length * bodies / 2
        while gas.contacts < end:
            gas.step()
            translation, rotation = gas.temperatures()
            seen.append(rotation / translation)
        means.append(np.mean(seen))
    return np.array(means[1:])


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def _quaternions(axis):
    """(w, x, y, z) of rotations that take z to the axis or to its opposite, which are the same to a body of revolution: the nearer."""
    x, y, z = np.where(axis[:, 2:] < 0, -axis, axis).T
    return _unit(np.stack([1 + z, -y, x, np.zeros(len(axis))], axis=1))
