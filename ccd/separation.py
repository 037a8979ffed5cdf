"""Two ellipsoids at rest: the pencil maximiser of the contact function, and with it normal, gap and contact point.

Symbols as in docs/theory.md. An ellipsoid is given by its semi-axis vectors s1, s2, s3 (lab frame, from the centre to the surface along
the principal axes); its shape matrix is X = s1 s1^T + s2 s2^T + s3 s3^T and its support function h(n) = |(s1.n, s2.n, s3.n)|.
r is the vector from the centre of A to the centre of B.
"""

from ccd.compiling import kernel, large_kernel
from ccd.lanes import sqrt
from ccd.tolerances import PENCIL_STEPS
from ccd.vectors import add_scaled, cross, dot, norm, scale, subtract


@kernel
def semi_axis_vectors(semi_axes, axes):
    return (scale(semi_axes[0], axes[0]), scale(semi_axes[1], axes[1]), scale(semi_axes[2], axes[2]))


@kernel
def shape_matrix(s):
    """X as its six different entries: xx, yy, zz, xy, xz, yz."""
    a, b, c = s
    return (a[0] * a[0] + b[0] * b[0] + c[0] * c[0],
            a[1] * a[1] + b[1] * b[1] + c[1] * c[1],
            a[2] * a[2] + b[2] * b[2] + c[2] * c[2],
            a[0] * a[1] + b[0] * b[1] + c[0] * c[1],
            a[0] * a[2] + b[0] * b[2] + c[0] * c[2],
            a[1] * a[2] + b[1] * b[2] + c[1] * c[2])


@kernel
def support(s, n):
    """h(n): the largest n.x on the body centred at the origin, eq. (4)."""
    p, q, w = dot(s[0], n), dot(s[1], n), dot(s[2], n)
    return sqrt(p * p + q * q + w * w)


@kernel
def support_point(s, n):
    """The point of the surface, relative to the centre, whose outward normal is n."""
    p, q, w = dot(s[0], n), dot(s[1], n), dot(s[2], n)
    over_h = 1.0 / sqrt(p * p + q * q + w * w)
    return scale(over_h, add_scaled(add_scaled(scale(p, s[0]), q, s[1]), w, s[2]))


@kernel
def _adjugate(m):
    xx, yy, zz, xy, xz, yz = m
    return (yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy, xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - yz * xx)


@kernel
def _quadratic_form(m, r):
    return (m[0] * r[0] * r[0] + m[1] * r[1] * r[1] + m[2] * r[2] * r[2]
            + 2 * (m[3] * r[0] * r[1] + m[4] * r[0] * r[2] + m[5] * r[1] * r[2]))


@kernel
def _double_product(m, k):
    """Trace of the product of two symmetric matrices."""
    return m[0] * k[0] + m[1] * k[1] + m[2] * k[2] + 2 * (m[3] * k[3] + m[4] * k[4] + m[5] * k[5])


@kernel
def _mixed_adjugate_form(m, k, r):
    """The term of r^T adj(m + k) r that is linear in both m and k."""
    return (r[0] * r[0] * (m[1] * k[2] + k[1] * m[2] - 2 * m[5] * k[5])
            + r[1] * r[1] * (m[0] * k[2] + k[0] * m[2] - 2 * m[4] * k[4])
            + r[2] * r[2] * (m[0] * k[1] + k[0] * m[1] - 2 * m[3] * k[3])
            + 2 * (r[0] * r[1] * (m[4] * k[5] + k[4] * m[5] - m[3] * k[2] - k[3] * m[2])
                   + r[0] * r[2] * (m[3] * k[5] + k[3] * m[5] - m[4] * k[1] - k[4] * m[1])
                   + r[1] * r[2] * (m[3] * k[4] + k[3] * m[4] - m[5] * k[0] - k[5] * m[0])))


@kernel
def pencil(a, b, r):
    """Bernstein coefficients of D = det Y (cubic in lambda, four of them) and N = r^T adj(Y) r (quadratic, three of them).

    Y = (1 - lambda) X_A + lambda X_B, so that the contact function (1) is f = lambda (1 - lambda) N / D. All coefficients are positive.
    Takes the shape matrices a, b as six entries each.
    """
    adj_a, adj_b = _adjugate(a), _adjugate(b)
    d0 = a[0] * adj_a[0] + a[3] * adj_a[3] + a[4] * adj_a[4]
    d3 = b[0] * adj_b[0] + b[3] * adj_b[3] + b[4] * adj_b[4]
    d = (d0, _double_product(adj_a, b) / 3, _double_product(adj_b, a) / 3, d3)
    return d, (_quadratic_form(adj_a, r), 0.5 * _mixed_adjugate_form(a, b, r), _quadratic_form(adj_b, r))


@kernel
def contact_value(d, n, x):
    """f at lambda = x from the coefficients of `pencil`."""
    y = 1 - x
    return (x * y * (n[0] * y * y + 2 * n[1] * y * x + n[2] * x * x)
            / (d[0] * y * y * y + 3 * d[1] * y * y * x + 3 * d[2] * y * x * x + d[3] * x * x * x))


@kernel
def balance(a, b):
    """Where to start: the maximiser for two spheres of the same mean squared semi-axes, from shape matrices a, b."""
    size_a, size_b = sqrt(a[0] + a[1] + a[2]), sqrt(b[0] + b[1] + b[2])
    return size_a / (size_a + size_b)


@kernel
def maximise(d, n, start, precision):
    """The maximiser of f in (0, 1), eq. (2), from the coefficients of `pencil`. -> lambda, converged.

    Newton on lambda (1 - lambda) (ln f)', which is nearly straight for any ratio of sizes, kept inside a bracket that shrinks (f is
    concave), until a step is below `precision` of the distance to the nearer end: the error is then about the square of that.
    """
    low, high, x = 0.0, 1.0, start
    for _ in range(PENCIL_STEPS):
        low, high, step = newton_step(d, n, low, high, x)
        x += step
        if abs(step) <= precision * min(x, 1 - x):
            return x, True
    return x, False


@kernel
def newton_step(d, n, low, high, x):
    """One step of `maximise` from x. -> the new bracket low, high, and the step."""
    y = 1 - x
    d01, d12, d23 = d[0] * y + d[1] * x, d[1] * y + d[2] * x, d[2] * y + d[3] * x
    d012, d123 = d01 * y + d12 * x, d12 * y + d23 * x
    cubic, cubic_1, cubic_2 = d012 * y + d123 * x, 3 * (d123 - d012), 6 * (d23 - 2 * d12 + d01)
    n01, n12 = n[0] * y + n[1] * x, n[1] * y + n[2] * x
    quadratic, quadratic_1, quadratic_2 = n01 * y + n12 * x, 2 * (n12 - n01), 2 * (n[2] - 2 * n[1] + n[0])
    under = x * y * quadratic
    under_1 = (y - x) * quadratic + x * y * quadratic_1
    under_2 = -2 * quadratic + 2 * (y - x) * quadratic_1 + x * y * quadratic_2
    rate = under_1 / under - cubic_1 / cubic                                                        # (ln f)'
    bend = under_2 / under - (under_1 / under)**2 - cubic_2 / cubic + (cubic_1 / cubic)**2          # (ln f)''
    if rate > 0:
        low = x
    else:
        high = x
    slope = (y - x) * rate + x * y * bend
    step = -x * y * rate / slope if slope < 0 else 2.0
    if not low <= x + step <= high:
        step = 0.5 * (low + high) - x
    return low, high, step


@kernel
def relative_pose(semi_axes_a, axes_a, semi_axes_b, axes_b, r):
    """The pair as it looks where B is the unit sphere: the semi-axis vectors g of A, and the vector t from A to B."""
    p, q, w = scale(1 / semi_axes_b[0], axes_b[0]), scale(1 / semi_axes_b[1], axes_b[1]), scale(1 / semi_axes_b[2], axes_b[2])
    a1, a2, a3 = axes_a
    return ((scale(semi_axes_a[0], (dot(p, a1), dot(q, a1), dot(w, a1))),
             scale(semi_axes_a[1], (dot(p, a2), dot(q, a2), dot(w, a2))),
             scale(semi_axes_a[2], (dot(p, a3), dot(q, a3), dot(w, a3)))), (dot(p, r), dot(q, r), dot(w, r)))


@kernel
def relative_pencil(g, t):
    """`pencil` of a `relative_pose`: the same contact function from sums of squares, which keep full precision for needles and plates."""
    g1, g2, g3 = g
    g12, g13, g23 = cross(g1, g2), cross(g1, g3), cross(g2, g3)
    gt1, gt2, gt3 = cross(g1, t), cross(g2, t), cross(g3, t)
    volume, t12, t13, t23 = dot(g12, g3), dot(g12, t), dot(g13, t), dot(g23, t)
    return ((volume * volume, (dot(g12, g12) + dot(g13, g13) + dot(g23, g23)) / 3, (dot(g1, g1) + dot(g2, g2) + dot(g3, g3)) / 3, 1.0),
            (t12 * t12 + t13 * t13 + t23 * t23, 0.5 * (dot(gt1, gt1) + dot(gt2, gt2) + dot(gt3, gt3)), dot(t, t)))


@kernel
def nearer_end(d, n):
    """A `relative_pencil` whose lambda is counted from the end where its maximiser is, and where to start. -> d, n, start, turned.

    Bodies of very different sizes have theirs close to an end: near 0 floats are dense enough, near 1 they are not.
    """
    size = sqrt(d[2])                                           # of A in units of B
    turned = size > 1
    return ((d[3], d[2], d[1], d[0]) if turned else d, (n[2], n[1], n[0]) if turned else n, min(size, 1.0) / (size + 1), turned)


@kernel
def contact_function(g, t, precision):
    """The maximum of (1) for a `relative_pose`. -> f, its lambda / (1 - lambda), converged. f is 0 for concentric bodies."""
    d, n = relative_pencil(g, t)
    if n[2] == 0:
        return 0.0, 1.0, True
    d, n, start, turned = nearer_end(d, n)
    x, converged = maximise(d, n, start, precision)
    return contact_value(d, n, x), (1 - x) / x if turned else x / (1 - x), converged


@kernel
def normal(a, b, r, x):
    """The unit vector along Y^-1 r: the separating direction that lambda = x gives, eq. (4).

    At the maximiser it is the normal, from A to B, of the bodies scaled until they touch.
    """
    y = 1 - x
    n = adjugate_times((y * a[0] + x * b[0], y * a[1] + x * b[1], y * a[2] + x * b[2],
                        y * a[3] + x * b[3], y * a[4] + x * b[4], y * a[5] + x * b[5]), r)
    return scale(1.0 / norm(n), n)


@kernel
def adjugate_times(m, r):
    """det(m) m^-1 r of a symmetric matrix, as its six entries."""
    m = _adjugate(m)
    return (m[0] * r[0] + m[3] * r[1] + m[4] * r[2], m[3] * r[0] + m[1] * r[1] + m[5] * r[2], m[4] * r[0] + m[5] * r[1] + m[2] * r[2])


@kernel
def best_plane(s_a, s_b, r, start, precision):
    """Maximise the contact function of two bodies given by semi-axis vectors. -> unit normal, lambda, converged."""
    return best_plane_of(shape_matrix(s_a), shape_matrix(s_b), r, start, precision)


@large_kernel
def best_plane_of(a, b, r, start, precision):
    """`best_plane` of two shape matrices."""
    d, n = pencil(a, b, r)
    x, converged = maximise(d, n, start, precision)
    return normal(a, b, r, x), x, converged


@kernel
def contact_point(centre_a, s_a, r, s_b, n):
    """Halfway between the supporting points of A and of B along n: the contact point when they touch."""
    on_a = support_point(s_a, n)
    on_b = subtract(r, support_point(s_b, n))
    return add_scaled(add_scaled(centre_a, 0.5, on_a), 0.5, on_b)
