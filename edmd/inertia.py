"""Moments of inertia, the motion of bodies of revolution (precession of the shape, spin about the axis), kinetic energy."""

import numpy as np

from ccd import checks
from ccd.precession import symmetry_axes, turning_of_shape
from ccd.quaternions import to_body, to_lab


def rotational_degrees(semi_axes):
    """Rotational degrees of freedom (n,) that collisions of smooth bodies exchange: 0 sphere, 2 body of revolution, 3 otherwise."""
    return np.choose(symmetry_axes(semi_axes), [2, 2, 2, 3, 0])


def principal_moments(inertia, semi_axes, masses):
    """Principal moments (n, 3) that the dynamics uses; see System for what is accepted."""
    n = len(semi_axes)
    kinds = symmetry_axes(semi_axes)
    if isinstance(inertia, str):
        if inertia == "solid":
            moments = solid_moments(semi_axes, masses)
            moments[kinds == 3] = moments[kinds == 3].mean(axis=1, keepdims=True)
        elif inertia == "sphere":
            moments = np.repeat(0.4 * masses * semi_axes.prod(axis=1)**(2 / 3), 3).reshape(n, 3)
        else:
            raise ValueError(f"inertia = {inertia!r}: expected 'solid', 'sphere' or principal moments (3,) or ({n}, 3)")
        return moments
    what = f"'solid', 'sphere' or principal moments (3,) or ({n}, 3)"
    moments = checks.real_array("inertia", inertia, (3,) if np.ndim(inertia) == 1 else (n, 3), what)
    moments = np.tile(moments, (n, 1)) if moments.ndim == 1 else moments
    if not (moments > 0).all():
        raise ValueError(f"inertia = {inertia!r}: every principal moment must be positive")
    axis = np.minimum(kinds, 2)
    across = [moments[np.arange(n), (axis + k) % 3] for k in (1, 2)]
    isotropic = (moments == moments[:, :1]).all(axis=1)
    if not (isotropic | ((kinds < 3) & (across[0] == across[1]))).all():
        raise ValueError(f"inertia = {inertia!r}: the free rotation of three different principal moments is not built yet; expected equal "
                         "moments, or for a body of revolution equal ones across its axis")
    return moments


def solid_moments(semi_axes, masses):
    """Principal moments (n, 3) of ellipsoids of uniform density: m (b^2 + c^2) / 5 about the first axis, and so on."""
    squares = semi_axes**2
    return masses[:, None] / 5 * (squares.sum(axis=1, keepdims=True) - squares)


def shape_turning(system, rough):
    """How the shape turns in free flight. -> turning (n, 3), across (n,), spin (n, 3): what smooth bodies keep for ever, in their frames.

    For a body of revolution about u with moments I_par and I_perp, L / I_perp = w + (I_par / I_perp - 1) (w.u) u stays constant: the axis
    precesses about it, and the body spins about its own axis at (1 - I_par / I_perp) (w.u) besides. For isotropic inertia the turning is w.
    Of smooth spheres all of w is kept, and the turning zero: a gas that cools by many decades must not be judged by a spin that does not.
    """
    axis, u = axis_directions(system)
    n, spin = np.arange(system.n), np.zeros((system.n, 3))
    along, across = system.moments[n, axis], system.moments[n, (axis + 1) % 3]
    turning = turning_of_shape(system.angular_velocities, u, along, across)
    if not rough:
        spheres = rotational_degrees(system.semi_axes) == 0
        spin[n, axis] = (1 - along / across) * (system.angular_velocities * u).sum(axis=1)
        spin[spheres] = to_body(system.orientations, system.angular_velocities)[spheres]
        turning[spheres] = 0.0
    return turning, across, spin


def axis_directions(system):
    """Index (n,) and direction (n, 3) in the lab of the symmetry axis, the third axis where there is none."""
    axis = np.minimum(symmetry_axes(system.semi_axes), 2)
    return axis, to_lab(system.orientations, np.eye(3)[axis])


def degrees_of_freedom(system, rough=False):
    """Those that exchange energy: 3 n - 3 of translation; 0, 2 or 3 of rotation a body (sphere, body of revolution, other; rough: 3)."""
    return max(3 * system.n - 3, 1) + (3 * system.n if rough else int(rotational_degrees(system.semi_axes).sum()))


def kinetic_energies(system, rough=False):
    """Translational energy without the common drift, and rotational energy, of smooth bodies of revolution without their spin."""
    masses = system.masses[:, None]
    drift = (masses * system.velocities).sum(axis=0) / masses.sum()
    translation = 0.5 * (masses * (system.velocities - drift)**2).sum()
    if rough:
        return translation, 0.5 * (system.moments * to_body(system.orientations, system.angular_velocities)**2).sum()
    kinds = symmetry_axes(system.semi_axes)
    axis, u = axis_directions(system)
    along = (system.angular_velocities * u).sum(axis=1, keepdims=True) * u
    active = np.where((kinds < 3)[:, None], system.angular_velocities - along, system.angular_velocities)
    moments = system.moments[np.arange(system.n), (axis + 1) % 3]
    return translation, 0.5 * (moments * (active**2).sum(axis=1))[kinds < 4].sum()


def temperature_of(system, rough=False):
    """kT = 2 E / degrees of freedom."""
    return 2 * sum(kinetic_energies(system, rough)) / degrees_of_freedom(system, rough)
