"""The whole rotation of rough bodies: spin about the symmetry axis takes part in their collisions (docs/theory.md, eq. (12) and (29)).

The shape of a free body of revolution turns at L / I_perp, which a row holds; the body spins about its own axis u besides, by
(I_perp / I_par - 1) (L.u) / I_perp, which moves no surface but drags on what it touches.
"""

from ccd.compiling import kernel
from ccd.vectors import add_scaled, cross, dot, load, scale
from edmd.flight import load_vectors
from edmd.state import INVERSE_INERTIA, SEMI_AXES, TURNING, VECTORS


@kernel
def principal_axes(row):
    """The three unit axes of the body at its own time."""
    a, b, c = load(row, SEMI_AXES)
    s = load_vectors(row, VECTORS)
    return scale(1 / a, s[0]), scale(1 / b, s[1]), scale(1 / c, s[2])


@kernel
def symmetry_axis(row):
    """0, 1, 2 for a body of revolution; 3 for three different axes; 4 for a sphere."""
    a, b, c = load(row, SEMI_AXES)
    if a == b and b == c:
        return 4
    return 2 if a == b else 1 if a == c else 0 if b == c else 3


@kernel
def angular_velocity(row, inverse_moments):
    """w = I^-1 L of a body with these inverse principal moments (3,)."""
    axes, momentum = principal_axes(row), scale(1 / row[INVERSE_INERTIA], load(row, TURNING))
    w = scale(inverse_moments[0] * dot(axes[0], momentum), axes[0])
    w = add_scaled(w, inverse_moments[1] * dot(axes[1], momentum), axes[1])
    return add_scaled(w, inverse_moments[2] * dot(axes[2], momentum), axes[2])


@kernel
def rotational_energy(row, inverse_moments):
    """L.w / 2, the spin about the axis included."""
    return 0.5 * dot(load(row, TURNING), angular_velocity(row, inverse_moments)) / row[INVERSE_INERTIA]


@kernel
def own_spin(row, inverse_moments):
    """Rate of the body about its symmetry axis against its shape, (w - L / I_perp).u."""
    axis = min(symmetry_axis(row), 2)
    s = load(row, VECTORS + 3 * axis)
    return (inverse_moments[axis] / row[INVERSE_INERTIA] - 1) * dot(load(row, TURNING), s) / row[SEMI_AXES + axis]


@kernel
def own_spins(rows, inverse_moments, spins):
    """`own_spin` of all bodies, into spins (n,)."""
    for body in range(len(rows)):
        spins[body] = own_spin(rows[body], inverse_moments[body])


@kernel
def yielding(row, inverse_mass, inverse_moments, lever):
    """The symmetric matrix (xx, yy, zz, yz, zx, xy) from an impulse at lever from the centre to the change of velocity of that point:
    1 / m + sum over the principal axes e of q q^T / I, q = e x lever."""
    axes = principal_axes(row)
    p, q, r = cross(axes[0], lever), cross(axes[1], lever), cross(axes[2], lever)
    i, j, k = inverse_moments[0], inverse_moments[1], inverse_moments[2]
    return (inverse_mass + i * p[0] * p[0] + j * q[0] * q[0] + k * r[0] * r[0],
            inverse_mass + i * p[1] * p[1] + j * q[1] * q[1] + k * r[1] * r[1],
            inverse_mass + i * p[2] * p[2] + j * q[2] * q[2] + k * r[2] * r[2],
            i * p[1] * p[2] + j * q[1] * q[2] + k * r[1] * r[2],
            i * p[2] * p[0] + j * q[2] * q[0] + k * r[2] * r[0],
            i * p[0] * p[1] + j * q[0] * q[1] + k * r[0] * r[1])
