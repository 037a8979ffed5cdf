"""Oracle: first contact of two ellipsoids in free flight, by looking at the contact function at many times.

Slow and plain, K pairs at once. The touching scale mu of a pair is the factor by which both bodies must grow to touch (mu < 1: they
overlap); it is sampled densely in time, its local minima are refined by golden section, and the first root of mu - 1 is bisected.
Rotations are scipy's; mu comes from the eigenvalues of one shape relative to the other. Only numpy and scipy.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

GOLDEN = (np.sqrt(5) - 1) / 2


@dataclass
class Flights:
    """K bodies at t = 0 and how they fly: arrays (K, 3), quaternions (K, 4) as (w, x, y, z), growth (K,)."""

    semi_axes: np.ndarray
    center: np.ndarray
    orientation: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    growth_rate: np.ndarray

    def __len__(self):
        return len(self.center)

    def pick(self, index):
        return type(self)(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    def at(self, time):
        """Centres (K, 3) and semi-axis vectors (K, 3, 3), as columns, each body at its own time (K,)."""
        turned = Rotation.from_rotvec(self.angular_velocity * time[:, None]) * Rotation.from_quat(np.roll(self.orientation, -1, axis=1))
        size = 1 + self.growth_rate * time
        return self.center + self.velocity * time[:, None], turned.as_matrix() * (self.semi_axes * size[:, None])[:, None, :]

    def moved(self, shift):
        return replace(self, center=self.center + shift)


@dataclass
class FreeFlights(Flights):
    """The same for bodies that turn freely with principal moments (K, 3), by a Runge-Kutta method; `course` from `free_courses`."""

    moments: np.ndarray
    course: np.ndarray

    def at(self, time):
        turned = np.empty((len(self), 4))
        kinds, which = np.unique([id(each) for each in self.course], return_inverse=True)
        for k in range(len(kinds)):
            rows = np.nonzero(which == k)[0]
            turned[rows] = np.roll(self.course[rows[0]](time[rows])[:4].T, -1, axis=1)
        size = 1 + self.growth_rate * time
        axes = Rotation.from_quat(turned).as_matrix() * (self.semi_axes * size[:, None])[:, None, :]
        return self.center + self.velocity * time[:, None], axes


def free_courses(orientation, angular_velocity, moments, t_max):
    """(K,) functions of times (T,) in [0, t_max], each giving a quaternion and the angular velocity in the body's frame, (7, T)."""
    def rates(_, state, moments):
        q, w = state[:4], state[4:]
        return np.concatenate([0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)]), np.cross(moments * w, w) / moments])

    courses = np.empty(len(orientation), dtype=object)
    for k, (q, spin) in enumerate(zip(orientation, angular_velocity)):
        start = Rotation.from_quat(np.roll(q, -1))
        state = np.concatenate([np.roll(start.as_quat(), 1), start.inv().apply(spin)])
        courses[k] = solve_ivp(rates, (0, t_max), state, "DOP853", args=(moments[k],), rtol=1e-13, atol=1e-13, dense_output=True).sol
    return courses


def contact_function_and_normal(r, axes_a, axes_b, steps=55):
    """f (K,), the Perram-Wertheim contact function, and the gradient n (K, 3) = df/dr / 2, along the contact normal from A to B.

    In the frame where A is the unit sphere, B has squared semi-axes m and r has components c along them:
    f = max over x of x (1 - x) sum c^2 / (1 - x + x m).
    """
    inverse = np.linalg.inv(axes_a)
    relative = inverse @ axes_b
    m, directions = np.linalg.eigh(relative @ relative.transpose(0, 2, 1))
    c = (directions.transpose(0, 2, 1) @ (inverse @ r[:, :, None]))[:, :, 0]
    x = _where_the_contact_function_is_largest(m.T.copy(), (c**2).T.copy(), steps)
    weighted = (x * (1 - x))[:, None] * c / ((1 - x)[:, None] + x[:, None] * m)
    normal = inverse.transpose(0, 2, 1) @ (directions @ weighted[:, :, None])
    return (weighted * c).sum(axis=1), normal[:, :, 0]


def _where_the_contact_function_is_largest(m, squares, steps):
    """x (K,) in (0, 1) where its slope is zero; m and c^2 as (3, K). Newton's steps, and halves where those lead astray."""
    low, high, x = np.zeros(m.shape[1]), np.ones(m.shape[1]), np.full(m.shape[1], 0.5)
    for _ in range(steps):
        y = 1 - x
        weight = y + x * m
        slope = (squares * (y**2 - x**2 * m) / weight**2).sum(axis=0)
        rising = slope > 0
        low, high = np.where(rising, x, low), np.where(rising, high, x)
        with np.errstate(invalid="ignore"):                             # concentric bodies: f is zero everywhere
            new = x + 0.5 * slope / (squares * m / weight**3).sum(axis=0)
        new = np.where((low <= new) & (new <= high), new, 0.5 * (low + high))
        near = np.abs(new - x) <= 1e-9 * np.minimum(x, y)               # the next step would be by its square
        x = new
        if near.all():
            break
    return x


def touching_scale(a, b, time):
    """mu (K,) of the pairs, each at its own time (K,)."""
    (center_a, axes_a), (center_b, axes_b) = a.at(time), b.at(time)
    return np.sqrt(contact_function_and_normal(center_b - center_a, axes_a, axes_b)[0])


def _samples(a, b, times):
    """mu (K, T) at shared times (T,)."""
    pairs = np.repeat(np.arange(len(a)), len(times))
    return touching_scale(a.pick(pairs), b.pick(pairs), np.tile(times, len(a))).reshape(len(a), -1)


def _minimum(a, b, low, high):
    """Time (K,) and value (K,) of the minimum of mu between low and high (K,), by golden section."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    mu_left, mu_right = touching_scale(a, b, left), touching_scale(a, b, right)
    for _ in range(45):
        first = mu_left < mu_right
        low, high = np.where(first, low, left), np.where(first, right, high)
        new = np.where(first, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        mu_new = touching_scale(a, b, new)
        left, right, mu_left, mu_right = (np.where(first, new, right), np.where(first, left, new),
                                          np.where(first, mu_new, mu_right), np.where(first, mu_left, mu_new))
    return np.where(mu_left < mu_right, left, right), np.minimum(mu_left, mu_right)


def deepest(a, b, t_max, samples=400):
    """Time (K,) and value (K,) of the smallest mu in [0, t_max]."""
    times = np.linspace(0, t_max, samples)
    lowest = _samples(a, b, times).argmin(axis=1)
    return _minimum(a, b, times[np.maximum(lowest - 1, 0)], times[np.minimum(lowest + 1, samples - 1)])


def first_contact(a, b, t_max, samples=800):
    """First contact time (K,) in [0, t_max]: inf for none, 0 for overlapping at the start; and the smallest mu seen (K,)."""
    times = np.linspace(0, t_max, samples)
    mu = _samples(a, b, times)
    ahead, behind = np.hstack([mu[:, 1:], mu[:, -1:]]), np.hstack([mu[:, :1], mu[:, :-1]])
    pair, k = np.nonzero((mu >= 1) & (mu <= ahead) & (mu <= behind) & (mu < 1.2))       # minima that may hide a contact between samples
    when, depth = _minimum(a.pick(pair), b.pick(pair), times[np.maximum(k - 1, 0)], times[np.minimum(k + 1, samples - 1)])
    smallest = mu.min(axis=1)
    np.minimum.at(smallest, pair, depth)
    inside = np.where((mu < 1).any(axis=1), times[(mu < 1).argmax(axis=1)], np.inf)     # a time when they overlap, the first known
    np.minimum.at(inside, pair[depth < 1], when[depth < 1])
    found = np.isfinite(inside) & (inside > 0)
    high = inside[found]
    low = times[np.maximum(np.searchsorted(times, high) - 1, 0)]
    low = np.where(touching_scale(a.pick(found), b.pick(found), low) < 1, 0, low)       # never, unless two minima share a sample
    for _ in range(60):
        middle = 0.5 * (low + high)
        overlap = touching_scale(a.pick(found), b.pick(found), middle) < 1
        low, high = np.where(overlap, low, middle), np.where(overlap, middle, high)
    contact = np.where(inside == 0, 0, np.inf)
    contact[found] = 0.5 * (low + high)
    return contact, smallest


def graze(a, b, t_max, depth, rounds=12, samples=200):
    """Move each B along the contact normal until the smallest mu in [0, t_max] is 1 - depth (K,). -> B, time (K,) of that minimum.

    A pair that is as deep as it should be, to rounding, is left alone: most are after half of the rounds.
    """
    center, when, going = b.center.copy(), np.empty(len(a)), np.arange(len(a))
    for _ in range(rounds):
        one, other = a.pick(going), replace(b, center=center).pick(going)
        time, mu = deepest(one, other, t_max, samples)
        (center_a, axes_a), (center_b, axes_b) = one.at(time), other.at(time)
        _, gradient = contact_function_and_normal(center_b - center_a, axes_a, axes_b)
        length = np.linalg.norm(gradient, axis=1)                   # mu grows by length / mu for each unit of a shift along the normal
        missing = 1 - depth[going] - mu
        center[going] += (missing * mu / length**2)[:, None] * gradient
        when[going] = time
        going = going[np.abs(missing) > 1e-15]
        if not len(going):
            break
    return replace(b, center=center), when
