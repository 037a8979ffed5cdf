"""What a collision does, in plain numpy: the rules of docs/theory.md, eqs. (26) to (29), from the contact that a system is in.

Shares no code with the product. A rule is a document: {"kind": "rough", "restitution": 0.9, ...}.
"""

import numpy as np
import reference
from scipy.integrate import solve_ivp


def contact_of(system, i, j, vector):
    """Normal from i to j, and the levers (2, 3) from both centres to the contact, of a touching pair; vector: from i to j's image."""
    turns = [reference.quat_to_R(system.orientations[k]) for k in (i, j)]
    a, b = (reference.shape_matrix(system.semi_axes[k], turn) for k, turn in zip((i, j), turns))
    _, _, n, from_i = reference.pw(a, b, vector)
    return n, np.array([from_i, from_i - vector])


def inverse_inertia(system, k):
    turn = reference.quat_to_R(system.orientations[k])
    return turn @ np.diag(1 / system.moments[k]) @ turn.T


def cross_matrix(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def effective(system, i, j, levers):
    """The 3x3 matrix from an impulse on j (minus that on i) to the change of the relative velocity of the surfaces."""
    return sum(np.eye(3) / system.masses[k] - cross_matrix(lever) @ inverse_inertia(system, k) @ cross_matrix(lever)
               for k, lever in zip((i, j), levers))


def surface_velocity(system, i, j, levers):
    """Of j's surface against i's at the contact."""
    at = [system.velocities[k] + np.cross(system.angular_velocities[k], lever) for k, lever in zip((i, j), levers)]
    return at[1] - at[0]


def normal_restitution(rule, approach):
    """e of this approach velocity."""
    if rule["kind"] == "elastic":
        return 1.0
    if rule["kind"] == "viscoelastic":
        x = np.sqrt(rule["dissipation"]) * approach**0.1           # the published coefficients
        return np.polyval([0.501086, 1], x) / np.polyval([0.532178, 0.577977, 1.15345, 0.501086, 1], x)
    if rule["kind"] == "power_law":
        return max(rule["restitution"], 1 - (1 - rule["restitution"]) * (approach / rule["velocity"])**rule["exponent"])
    return rule["restitution"]


def viscoelastic_restitution(d):
    """By integration of m x'' = -rho (x^1.5 + 1.5 A x^0.5 x') with m = rho = v = 1 and A = 2 d / 3, until the force has gone."""
    def motion(_, y):
        x, v = max(y[0], 0.0), y[1]
        return [v, -x**1.5 - d * np.sqrt(x) * v]

    def let_go(_, y):
        return y[0] + d * y[1]
    let_go.terminal, let_go.direction = True, -1
    return -solve_ivp(motion, (0, 100), [0.0, 1.0], events=let_go, rtol=1e-11, atol=1e-13).y[1, -1]


def impulse_and_loss(rule, velocity, n, matrix):
    """(P on j, energy lost) for a contact, each part from a linear system solved by numpy."""
    approach, along = -velocity @ n, n @ matrix @ n
    e = normal_restitution(rule, approach)
    impulse, loss = (1 + e) * approach / along * n, 0.5 * (1 - e * e) * approach**2 / along
    if rule["kind"] == "rough":
        beta = rule["tangential_restitution"]
        stop_approach, stop = approach / along * n, -np.linalg.solve(matrix, velocity)
        left = velocity + matrix @ stop_approach
        impulse = (1 + e) * stop_approach + (1 + beta) * (stop - stop_approach)
        loss += 0.5 * (1 - beta * beta) * left @ np.linalg.solve(matrix, left)
    return impulse, loss


def after(system, i, j, levers, impulse):
    """Velocities and angular velocities (2, 3) of both after the impulse."""
    signs = (-1, 1)
    v = [system.velocities[k] + sign * impulse / system.masses[k] for k, sign in zip((i, j), signs)]
    w = [system.angular_velocities[k] + sign * inverse_inertia(system, k) @ np.cross(lever, impulse)
         for k, lever, sign in zip((i, j), levers, signs)]
    return np.array(v), np.array(w)


def kinetic_energy(system):
    """All of it, about the axes too."""
    spin = np.einsum("nji,nj->ni", [reference.quat_to_R(q) for q in system.orientations], system.angular_velocities)
    return 0.5 * (system.masses[:, None] * system.velocities**2).sum() + 0.5 * (system.moments * spin**2).sum()
