"""Two ellipsoids at rest by the signs of a polynomial: the paper's Section 2 and Appendix A (eqs. (16) to (18) of docs/theory.md).

Everything is seen from where B is the unit sphere (`separation.relative_pose`): g holds the semi-axis vectors of A, t the vector from
A to B. With A's own frame scaled to its unit sphere as well, the paper's matrices are A = diag(1, 1, 1, -1) and
b = M_A^T M_B^-T B M_B^-1 M_A with the columns (g1, 0), (g2, 0), (g3, 0), (-t, 1) of M_B^-1 M_A and B = diag(1, 1, 1, -1).
"""

from ccd.compiling import kernel
from ccd.separation import contact_function
from ccd.status import State
from ccd.tolerances import ROUNDING, SHARP, TOUCHING_STATE, UNDERFLOW
from ccd.vectors import dot

OVERLAPPING, TOUCHING, SEPARATE = State.OVERLAPPING.value, State.TOUCHING.value, State.SEPARATE.value
UNCERTAIN = 2               # what the polynomial answers when rounding might have decided


@kernel
def _matrix(g, t):
    """The ten different entries of b: b11, b22, b33, b12, b13, b23, b14, b24, b34, b44."""
    g1, g2, g3 = g
    return (dot(g1, g1), dot(g2, g2), dot(g3, g3), dot(g1, g2), dot(g1, g3), dot(g2, g3),
            -dot(g1, t), -dot(g2, t), -dot(g3, t), dot(t, t) - 1)


@kernel
def polynomial(g, t, det):
    """T3, T2, T1, T0 of f(lambda) = det(lambda A - b) = -lambda^4 + T3 lambda^3 + ..., eq. (16); det is that of g.

    Generate-Characteristic-Polynomial of Appendix A at ea = eb = ec = 1: a pose that holds the semi-axes, rigid or affine.
    """
    b11, b22, b33, b12, b13, b23, b14, b24, b34, b44 = _matrix(g, t)
    b12s, b13s, b14s, b23s, b24s, b34s = b12 * b12, b13 * b13, b14 * b14, b23 * b23, b24 * b24, b34 * b34
    b2233 = b22 * b33
    term_a = b11 + b22 + b33
    term_b = (b2233 - b23s) + (b11 * b33 - b13s) + (b11 * b22 - b12s)
    twice = b34 * (b23 * b24 + b13 * b14) + b12 * (b14 * b24 - b13 * b23)
    t1 = (-term_b * b44 + b11 * (b2233 + b34s + b24s - b23s) + b22 * (b34s + b14s - b13s) + b33 * (b24s + b14s - b12s)
          - 2 * twice)
    return term_a - b44, term_a * b44 - term_b - b34s - b14s - b24s, t1, -det * det


@kernel
def magnitudes(g, t):
    """The sizes of the terms that T3, T2 and T1 are summed from: |b_ij| <= sqrt(b_ii b_jj) bounds each of them."""
    b11, b22, b33, q = dot(g[0], g[0]), dot(g[1], g[1]), dot(g[2], g[2]), dot(t, t)
    p1, p2, p3 = b11 + b22 + b33, b11 * b22 + b11 * b33 + b22 * b33, b11 * b22 * b33
    return p1 + q + 1, p1 * (2 * q + 1) + 2 * p2, 6 * (p2 * (q + 1) + p3)


@kernel
def state_by_roots(coefficients, sizes, precision):
    """Theorem 1: State, or UNCERTAIN where a change of the coefficients by `precision` of their `sizes` might change the answer.

    Sturm's sequence ends in the discriminant, which tells two real roots from four; two are always positive. Of four real roots,
    all are positive exactly when the signs of the coefficients alternate (Descartes). Eqs. (17) and (18). Free of branches, so that
    a loop over pairs becomes vector instructions.
    """
    t3, t2, t1, t0 = coefficients
    b, c, d, e = -0.25 * t3, -t2 / 6, -0.25 * t1, -t0           # -f = x^4 + 4 b x^3 + 6 c x^2 + 4 d x + e
    big_b, big_c, big_d = 0.25 * sizes[0], sizes[1] / 6, 0.25 * sizes[2]
    i = e - 4 * b * d + 3 * c * c
    j = c * e + 2 * b * c * d - d * d - b * b * e - c * c * c
    discriminant = i * i * i - 27 * j * j
    error_i = 2 * precision * (e + 4 * big_b * big_d + 3 * big_c * big_c)
    error_j = 3 * precision * (big_c * e + 2 * big_b * big_c * big_d + big_d * big_d + big_b * big_b * e + big_c * big_c * big_c)
    error = 3 * (abs(i) + error_i)**2 * error_i + 27 * (2 * abs(j) + error_j) * error_j + UNDERFLOW
    alternating = (b < 0) & (c > 0) & (d < 0)
    surely_alternating = (b < -precision * big_b) & (c > precision * big_c) & (d < -precision * big_d)
    certain = surely_alternating | ((abs(discriminant) > error) & (abs(discriminant) < 1 / UNDERFLOW))
    separate = (discriminant > 0) & (not alternating)
    return UNCERTAIN if not certain else SEPARATE if separate else OVERLAPPING


@kernel
def state_by_contact_function(f):
    """State by the sign of f - 1; UNCERTAIN for nan."""
    return TOUCHING if abs(f - 1) <= TOUCHING_STATE else SEPARATE if f > 1 else OVERLAPPING if f < 1 else UNCERTAIN


@kernel
def margin(aspect):
    """The precision that `state_by_roots` must have: it may decide neither within the band of TOUCHING nor by rounding."""
    return 2 * TOUCHING_STATE + ROUNDING * aspect


@kernel
def aspect_ratio(semi_axes):
    a, b, c = semi_axes
    return max(max(a, b), c) / min(min(a, b), c)


@kernel
def decided_state(g, t, det, aspect):
    """State by the roots where they are certain, else by the contact function."""
    found = state_by_roots(polynomial(g, t, det), magnitudes(g, t), margin(aspect))
    if found != UNCERTAIN:
        return found
    f, _, converged = contact_function(g, t, SHARP)
    return state_by_contact_function(f) if converged else UNCERTAIN
