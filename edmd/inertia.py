"""Moments of inertia, how a free body moves with them, and kinetic energy."""

import numpy as np

from ccd import checks
from ccd.precession import NO_AXIS, SPHERE, symmetry_axes
from ccd.quaternions import to_body, to_lab
from edmd.state import FREE, STEADY, STILL


def motions(semi_axes, moments, rough=False):
    """(n,): STILL for spheres, STEADY where the inertia is isotropic or of revolution about the axis of the shape, FREE otherwise.

    Rough bodies feel how their surfaces turn, even spheres: STEADY for isotropic inertia, FREE otherwise.
    """
    kinds = symmetry_axes(semi_axes)
    axis, n = np.minimum(kinds, 2), np.arange(len(kinds))
    of_revolution = (moments[n, (axis + 1) % 3] == moments[n, (axis + 2) % 3]) & (kinds < NO_AXIS)
    isotropic = (moments == moments[:, :1]).all(axis=1)
    if rough:
        return np.where(isotropic, STEADY, FREE)
    return np.where(kinds == SPHERE, STILL, np.where(isotropic | of_revolution, STEADY, FREE))


def rotational_degrees(semi_axes, moments, rough=False):
    """Rotational degrees of freedom (n,) that collisions exchange: of smooth bodies 0 for a sphere, 2 for a body of revolution (whose
    moments across its axis agree), 3 otherwise; 3 of rough ones."""
    if rough:
        return np.full(len(semi_axes), 3)
    motion = motions(semi_axes, moments)
    return np.array([0, 3, 3])[motion] - ((symmetry_axes(semi_axes) < NO_AXIS) & (motion == STEADY))


def principal_moments(inertia, semi_axes, masses):
    """Principal moments (n, 3) that the dynamics uses; see System for what is accepted."""
    n = len(semi_axes)
    if isinstance(inertia, str):
        if inertia == "solid":
            return solid_moments(semi_axes, masses)
        if inertia == "sphere":
            return np.repeat(0.4 * masses * semi_axes.prod(axis=1)**(2 / 3), 3).reshape(n, 3)
        raise ValueError(f"inertia = {inertia!r}: expected 'solid', 'sphere' or principal moments (3,) or ({n}, 3)")
    what = f"'solid', 'sphere' or principal moments (3,) or ({n}, 3)"
    moments = checks.real_array("inertia", inertia, (3,) if np.ndim(inertia) == 1 else (n, 3), what)
    moments = np.tile(moments, (n, 1)) if moments.ndim == 1 else moments
    if not (moments > 0).all():
        raise ValueError(f"inertia = {inertia!r}: every principal moment must be positive")
    return moments


def solid_moments(semi_axes, masses):
    """Principal moments (n, 3) of ellipsoids of uniform density: m (b^2 + c^2) / 5 about the first axis, and so on."""
    squares = semi_axes**2
    return masses[:, None] / 5 * (squares[:, [1, 2, 0]] + squares[:, [2, 0, 1]])


def angular_momenta(system):
    """(n, 3), in the lab frame."""
    return to_lab(system.orientations, system.moments * to_body(system.orientations, system.angular_velocities))


def angular_velocities(orientations, momenta, moments):
    """(n, 3), in the lab frame, from angular momenta."""
    return to_lab(orientations, to_body(orientations, momenta) / moments)


def own_spin(system):
    """Rate (n,) at which a body of revolution in STEADY motion turns about its own axis besides: (1 - I_par / I_perp)(w.u), constant."""
    axis = np.minimum(symmetry_axes(system.semi_axes), 2)
    u, n = to_lab(system.orientations, np.eye(3)[axis]), np.arange(system.n)
    along, across = system.moments[n, axis], system.moments[n, (axis + 1) % 3]
    steady = motions(system.semi_axes, system.moments) == STEADY
    return np.where(steady, (1 - along / across) * (system.angular_velocities * u).sum(axis=1), 0.0)


def degrees_of_freedom(system, rough=False):
    """Those that exchange energy: 3 n - 3 of translation, and the rotational ones of each body."""
    return max(3 * system.n - 3, 1) + int(rotational_degrees(system.semi_axes, system.moments, rough).sum())


def kinetic_energies(system, rough=False):
    """Translational energy without the common drift, and rotational energy of the motions that collisions exchange."""
    masses = system.masses[:, None]
    drift = (masses * system.velocities).sum(axis=0) / masses.sum()
    translation = 0.5 * (masses * (system.velocities - drift)**2).sum()
    active = to_body(system.orientations, system.angular_velocities)
    degrees = rotational_degrees(system.semi_axes, system.moments, rough)
    axis = np.minimum(symmetry_axes(system.semi_axes), 2)
    active[degrees == 2, axis[degrees == 2]] = 0.0
    return translation, 0.5 * (system.moments * active**2)[degrees > 0].sum()


def temperature_of(system, rough=False):
    """kT = 2 E / degrees of freedom."""
    return 2 * sum(kinetic_energies(system, rough)) / degrees_of_freedom(system, rough)
