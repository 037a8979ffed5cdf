"""Which pairs of bodies cannot touch within a frame (paper, Sec. 4.1): bounding spheres, and a separating plane carried with one body.

A frame goes from t = 0 to 1; bodies move by the rigid interpolant, a linear quaternion curve and a linear translation.
"""

from math import inf

from ccd.bernstein import control_points, elevate, first_root, restrict, set_product
from ccd.compiling import kernel
from ccd.motion.tensors import six
from ccd.rotation import multiply
from ccd.vectors import add, dot, scale, subtract


@kernel
def spheres_meet(r_start, r_end, reach, end):
    """Whether two centres, whose difference goes linearly from r_start to r_end, come within reach of each other in [0, end]."""
    velocity = subtract(r_end, r_start)
    speed = dot(velocity, velocity)
    nearest = min(max(-dot(r_start, velocity) / speed, 0.0), end) if speed > 0 else 0.0
    r = add(r_start, scale(nearest, velocity))
    return dot(r, r) <= reach * reach


@kernel
def _carried(p, m, q):
    """p m q* of quaternions p, q and a vector m, plus q m p*: half of it, for p = q, is the turned vector times |q|^2."""
    _, x, y, z = multiply(multiply(p, (0.0, m[0], m[1], m[2])), (q[0], -q[1], -q[2], -q[3]))
    _, u, v, w = multiply(multiply(q, (0.0, m[0], m[1], m[2])), (p[0], -p[1], -p[2], -p[3]))
    return (x + u, y + v, z + w)


@kernel
def _form(m, n, k):
    """n^T m k of a symmetric matrix."""
    return (m[0] * n[0] * k[0] + m[1] * n[1] * k[1] + m[2] * n[2] * k[2] + m[3] * (n[0] * k[1] + n[1] * k[0])
            + m[4] * (n[0] * k[2] + n[2] * k[0]) + m[5] * (n[1] * k[2] + n[2] * k[1]))


@kernel
def _square(q, p):
    return q[0] * p[0] + q[1] * p[1] + q[2] * p[2] + q[3] * p[3]


@kernel
def plane_holds(plane, turn, r, a, end, work):
    """Whether A stays on its side of the plane that touches B, has B on the other side and moves with B, throughout [0, end], eq. (25).

    plane: (m, h), the unit normal from A to B in the frame of B, and B's support value along it. turn: quaternions of B at 0 and 1; r:
    vectors from the centre of A to that of B at 0 and 1; a: Tensors of A. work: (4, 11). With n = U m the plane is at distance w / E from
    A's centre, w = n.r - h E, and A is clear of it while w^2 mu - n^T q n, of degree 10, is positive.
    """
    m, h = plane
    first, last = turn
    n = scale(0.5, _carried(first, m, first)), _carried(first, m, last), scale(0.5, _carried(last, m, last))
    e = _square(first, first), 2 * _square(first, last), _square(last, last)
    w, squared, clear, form = work[0, :4], work[1, :7], work[2, :11], work[3, :11]
    w[0] = dot(n[0], r[0]) - h * e[0]
    w[1] = dot(n[0], r[1]) + dot(n[1], r[0]) - h * (e[0] + e[1])
    w[2] = dot(n[1], r[1]) + dot(n[2], r[0]) - h * (e[1] + e[2])
    w[3] = dot(n[2], r[1]) - h * e[2]
    if not w[0] > 0:
        return False
    set_product(squared, 1.0, w, w)
    set_product(clear, 1.0, squared, a.mu)
    for k in range(11):
        form[k] = 0.0
    for i in range(3):
        for j in range(3):
            for k in range(5):
                form[i + j + k] += _form(six(a.q, k), n[i], n[j])
    elevate(form, 8, 10)
    for k in range(11):
        clear[k] -= form[k]
    control_points(clear, clear)
    restrict(clear, 0.0, end)
    return clear[0] > 0 and first_root(clear, form) == inf
