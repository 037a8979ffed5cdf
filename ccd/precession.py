"""How the shape of a free solid turns: eq. (12) of docs/theory.md, for arrays."""

import numpy as np

NO_AXIS, SPHERE = 3, 4


def symmetry_axes(semi_axes):
    """(n,): 0, 1, 2 for bodies of revolution about that axis, NO_AXIS for three different semi-axes, SPHERE for three equal ones."""
    a, b, c = semi_axes.T
    return np.where((a == b) & (b == c), SPHERE, np.where(a == b, 2, np.where(a == c, 1, np.where(b == c, 0, NO_AXIS))))


def turning_of_shape(angular_velocity, axis, along, across):
    """L / I_perp (n, 3), the constant rate at which the shape of a free body turns, from its angular velocity (n, 3) at one moment.

    axis: direction (n, 3) of the symmetry axis in the lab then; along, across: principal moments about it and across it. With u the axis,
    L / I_perp = w + (I_par / I_perp - 1) (w.u) u.
    """
    spin = (angular_velocity * axis).sum(axis=1)
    return angular_velocity + ((along / across - 1) * spin)[:, None] * axis
