"""Oracle: hard ellipsoids in a periodic cell, one collision after another, in plain numpy: slow, and of the product only its numbers.

First contacts by sampling: a window of time is cut into segments, each is looked at in its middle and dropped when the plane that best
separates the bodies there cannot be reached within it, and the rest is cut again, down to 1e-6 of the window; where bodies overlap in a
middle the root of the touching scale is found between that and the segment before. Contacts are impulses by the reference formula. A body
with two equal moments turns as a symmetric top, any other by an integration of Euler's equations.
"""

from itertools import product

import numpy as np
import reference
from dense import contact_function_and_normal
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

CUT = 16                    # into how many a segment is cut
FINEST = 1e-6               # width of the last segments, in units of the window
BEYOND = 1.001              # how far the twin looks, in units of the time of a record's last collision
STEPS = 12                  # of the pencil parameter where any good plane will do,
PRECISE = 28                # and where the touching scale must be exact: it is stationary there


class Twin:
    """Bodies of a state (arrays as those of a System) from its moment on, time 0."""

    def __init__(self, state):
        self.box = np.array(state.box)
        self.center = np.array(state.positions)
        self.frame = Rotation.from_quat(np.array(state.orientations), scalar_first=True).as_matrix()
        self.semi_axes, self.masses, self.moments = np.array(state.semi_axes), np.array(state.masses), np.array(state.moments)
        self.velocity, self.spin = np.array(state.velocities), np.array(state.angular_velocities)
        self.time = 0.0
        self.since = np.zeros(len(self.center))         # every body is kept as it was at its last collision
        self.radius = self.semi_axes.max(axis=1)
        self.flights = {}
        self.slender = self.radius - self.semi_axes.min(axis=1)
        self.turning = np.array([self._turning(body) for body in range(len(self.center))])
        self.heights = 1 / np.linalg.norm(np.linalg.inv(self.box), axis=0)      # of the cell

    def collisions(self, count, until):
        """The next collisions, so many or as many as there are up to a time: (time, i, j) in order, i < j."""
        self.until = until
        found, record = self._first_contacts(*self._images(np.arange(len(self.center)), until), until), []
        while found and len(record) < count:
            time, i, j, shift = min(found, key=lambda contact: contact[0])
            self._collide(time, i, j, shift)
            record.append((time, min(i, j), max(i, j)))
            if len(record) < count:
                kept = [contact for contact in found if not {i, j} & {*contact[1:3]}]
                found = kept + self._first_contacts(*self._images(np.array([i, j]), until), until)
        return record

    def _turning(self, body):
        """The angular velocity of the shape of a symmetric top, constant in free flight: L / I_perp; of any other body nan."""
        moments, frame = self.moments[body], self.frame[body]
        across = next((moments[(axis + 1) % 3] for axis in range(3) if moments[(axis + 1) % 3] == moments[(axis + 2) % 3]), np.nan)
        return frame @ (moments * (frame.T @ self.spin[body])) / across

    def _fastest_turning(self):
        """Bounds on the angular velocities of the shapes: |L| / I_min where a body tumbles."""
        momentum = self.moments * np.einsum("kji,kj->ki", self.frame, self.spin)
        tumbling = np.linalg.norm(momentum, axis=1) / self.moments.min(axis=1)
        return np.where(np.isnan(self.turning[:, 0]), tumbling, np.linalg.norm(self.turning, axis=1))

    def _frames(self, body, span):
        """Orientations of bodies a span after their last collision."""
        frames = Rotation.from_rotvec(np.nan_to_num(self.turning[body]) * span[:, None]).as_matrix() @ self.frame[body]
        for free in np.unique(body[np.isnan(self.turning[body, 0])]):
            frames[body == free] = self._tumbling(free)(span[body == free])[:9].T.reshape(-1, 3, 3)
        return frames

    def _tumbling(self, body):
        """Orientation and angular velocity in the body's frame, as twelve numbers, as a function of the span since its last collision."""
        if body not in self.flights:
            moments = self.moments[body]

            def motion(_, y):
                frame, spin = y[:9].reshape(3, 3), y[9:]
                return np.concatenate([np.cross(frame, spin).ravel(), np.cross(moments * spin, spin) / moments])

            start = np.concatenate([self.frame[body].ravel(), self.frame[body].T @ self.spin[body]])
            self.flights[body] = solve_ivp(motion, (0, self.until - self.since[body]), start, rtol=1e-12, atol=1e-14, method="DOP853",
                                           dense_output=True).sol
        return self.flights[body]

    def _at(self, body, time):
        """Centres and semi-axis vectors, as columns, of bodies at times."""
        span = time - self.since[body]
        return self.center[body] + self.velocity[body] * span[:, None], self._frames(body, span) * self.semi_axes[body][:, None, :]

    def _bring(self, body, time):
        span = time - self.since[body]
        if np.isnan(self.turning[body, 0]):
            end = self._tumbling(body)(span)
            frame = end[:9].reshape(3, 3)
            spin = frame @ end[9:]
        else:
            turn = Rotation.from_rotvec(self.turning[body] * span).as_matrix()
            frame, spin = turn @ self.frame[body], turn @ self.spin[body]
        self.center[body] += self.velocity[body] * span
        self.frame[body], self.spin[body], self.since[body] = frame, spin, time
        self.flights.pop(body, None)

    def _images(self, bodies, until):
        """Pairs (i, j, shift of j) of these bodies with all others whose bounding spheres meet until then."""
        n, center = len(self.center), self.center + self.velocity * (self.time - self.since)[:, None]
        furthest = 2 * self.radius.max() + 2 * np.linalg.norm(self.velocity, axis=1).max() * (until - self.time)
        reach = np.floor(0.5 + furthest / self.heights).astype(int)
        shifts = np.array(list(product(*(range(-r, r + 1) for r in reach)))) @ self.box
        i, j = np.repeat(bodies, n), np.tile(np.arange(n), len(bodies))
        once = np.where(np.isin(j, bodies), i < j, i != j)
        i, j = i[once], j[once]
        r = center[j] - center[i]
        nearest = -np.round(r @ np.linalg.inv(self.box)) @ self.box
        i, j = np.repeat(i, len(shifts)), np.repeat(j, len(shifts))
        shift = np.repeat(nearest, len(shifts), axis=0) + np.tile(shifts, (len(nearest), 1))
        r, v = center[j] + shift - center[i], self.velocity[j] - self.velocity[i]
        closest = np.clip(-(r * v).sum(axis=1) / np.maximum((v**2).sum(axis=1), 1e-300), 0, until - self.time)
        near = np.linalg.norm(r + v * closest[:, None], axis=1) <= self.radius[i] + self.radius[j]
        return i[near], j[near], shift[near]

    def _looked_at(self, i, j, shift, time, steps):
        """Touching scale and the gap between the planes of a good normal, a lower bound of the distance."""
        (center_a, axes_a), (center_b, axes_b) = self._at(i, time), self._at(j, time)
        r = center_b + shift - center_a
        f, n = contact_function_and_normal(r, axes_a, axes_b, steps)
        n /= np.linalg.norm(n, axis=1)[:, None]
        supports = np.linalg.norm(np.einsum("ki,kij->kj", n, axes_a), axis=1) + np.linalg.norm(np.einsum("ki,kij->kj", n, axes_b), axis=1)
        return np.sqrt(f), (n * r).sum(axis=1) - supports

    def _first_contacts(self, i, j, shift, until):
        """(time, i, j, shift) for every one of these pairs that touches between now and then."""
        window = until - self.time
        if window <= 0 or len(i) == 0:
            return []
        swing = self._fastest_turning() * self.slender           # by which supports change at most
        fastest = np.linalg.norm(self.velocity[j] - self.velocity[i], axis=1) + swing[i] + swing[j]
        inside = np.full(len(i), np.inf)                    # a time when the pair overlaps, the first known
        pair, middle, width = np.arange(len(i)), np.full(len(i), self.time + window / 2), window
        while len(pair) and width > FINEST * window:
            mu, gap = self._looked_at(i[pair], j[pair], shift[pair], middle, STEPS)
            deep = np.flatnonzero(mu < 1)
            if len(deep):
                k = pair[deep]
                deep = deep[self._looked_at(i[k], j[k], shift[k], middle[deep], PRECISE)[0] < 1]
            np.minimum.at(inside, pair[deep], middle[deep])
            alive = (gap < fastest[pair] * width / 2) & (middle - width / 2 < inside[pair])
            width /= CUT
            middle = (middle[alive, None] + width * (np.arange(CUT) - (CUT - 1) / 2)).ravel()
            pair = np.repeat(pair[alive], CUT)
        touching = np.flatnonzero(np.isfinite(inside))
        return [(self._root(i[k], j[k], shift[k], inside[k], width * CUT), int(i[k]), int(j[k]), shift[k]) for k in touching]

    def _root(self, i, j, shift, inside, width):
        """The time when the touching scale falls through 1, between an overlap and the segment before it, which is free."""
        def beyond(time):
            return self._looked_at(np.array([i]), np.array([j]), shift[None], np.array([time]), PRECISE)[0][0] - 1
        before = max(inside - 2 * width, self.time)
        return brentq(beyond, before, inside, xtol=1e-7 * width, rtol=1e-15) if beyond(before) > 0 else before

    def _collide(self, time, i, j, shift):
        self._bring(i, time)
        self._bring(j, time)
        self.time = time
        axes_a, axes_b = self.frame[i] * self.semi_axes[i], self.frame[j] * self.semi_axes[j]
        r = self.center[j] + shift - self.center[i]
        _, n = contact_function_and_normal(r[None], axes_a[None], axes_b[None])
        n = n[0] / np.linalg.norm(n[0])
        arm_a, arm_b = (axes @ (axes.T @ n) / np.linalg.norm(axes.T @ n) for axes in (axes_a, axes_b))
        self.velocity[i], self.spin[i], self.velocity[j], self.spin[j], _ = reference.collide(
            self.masses[i], self.moments[i], self.frame[i], self.velocity[i], self.spin[i], arm_a,
            self.masses[j], self.moments[j], self.frame[j], self.velocity[j], self.spin[j], -arm_b, n)
        self.turning[i], self.turning[j] = self._turning(i), self._turning(j)


def disagreement(start, record, end, tolerance=1e-8):
    """None, or in words how a record of collisions [(time, i, j), ...], from a start to the state at the last one, is not the twin's.

    tolerance: of times, in units of the last one. Two plates that rattle multiply rounding by ten a collision.
    """
    twin, last = Twin(start), record[-1][0]
    own = twin.collisions(len(record), last * BEYOND)
    for number, (theirs, ours) in enumerate(zip(record, own)):
        if theirs[1:] != ours[1:] or abs(theirs[0] - ours[0]) > tolerance * last:
            what = "missed" if ours[0] < theirs[0] else "invented"
            return f"collision {number}: {theirs} where the twin finds {ours}: {what}"
    if len(own) < len(record):
        return f"collision {len(own)}: {record[len(own)]} invented, the twin finds none"
    apart = abs(twin.velocity - end.velocities).max() / abs(end.velocities).max()
    return f"velocities differ by {apart:.3g} after {len(record)} collisions" if apart > 1e2 * tolerance else None
