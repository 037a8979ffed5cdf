"""What it costs to turn a free body with three different moments of inertia exactly, and how exact it is. One line of JSON.

    python benchmarks/free_turning.py --moments 1.64 2.2025 2.5625

For each angle |w| t: nanoseconds of CPU time a turn for random bodies (`turn_ns`) and where each turn starts from the one before
(`chain_ns`), both with their loop, and how far a turn and back ends from where it began (`there_and_back`, the largest of the bodies).
`per_constant` compares with turning at a constant rate in the same loop.
"""

import argparse
import json
import time

import numba
import numpy as np
from provenance import provenance

from ccd.free_top import angular_velocity, turn_freely
from ccd.rotation import load_quaternion, turn
from ccd.vectors import load, norm

BODIES = 64
ANGLES = (0.01, 0.1, 0.3, 1.0, 10.0, 100.0)


@numba.njit(error_model="numpy")
def random_bodies(q, momentum, inverse_moments, times, n):
    total = 0.0
    for k in range(n):
        i = k % BODIES
        w, x, y, z = turn_freely(load_quaternion(q[i], 0), load(momentum[i], 0), inverse_moments, times[i])
        total += w + x + y + z
    return total


@numba.njit(error_model="numpy")
def constant_rates(q, momentum, inverse_moments, times, n):
    total = 0.0
    for k in range(n):
        i = k % BODIES
        w, x, y, z = turn(load_quaternion(q[i], 0), load(momentum[i], 0), times[i])
        total += w + x + y + z
    return total


@numba.njit(error_model="numpy")
def chained(q, momentum, inverse_moments, times, n):
    turned = load_quaternion(q[0], 0)
    for _ in range(n):
        turned = turn_freely(turned, load(momentum[0], 0), inverse_moments, times[0])
    return turned[0]


def nanoseconds(loop, *arguments, n=300_000):
    loop(*arguments, 10)
    best = np.inf
    for _ in range(7):
        began = time.process_time()
        loop(*arguments, n)
        best = min(best, time.process_time() - began)
    return 1e9 * best / n


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=float, nargs=3, default=[1.64, 2.2025, 2.5625])
    options = parser.parse_args()
    rng, inverse = np.random.default_rng(1), tuple(1 / np.array(options.moments))
    q, momentum = rng.normal(size=(BODIES, 4)), rng.normal(size=(BODIES, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    given = [(tuple(q[k].tolist()), tuple(momentum[k].tolist()), inverse) for k in range(BODIES)]
    rates = np.array([norm(angular_velocity(*each)) for each in given])
    rows = []
    for angle in ANGLES:
        arguments = (q, momentum, inverse, angle / rates)
        back = [turn_freely(turn_freely(*each, t), *each[1:], -t) for each, t in zip(given, (angle / rates).tolist())]
        spin, steady = nanoseconds(random_bodies, *arguments), nanoseconds(constant_rates, *arguments)
        rows.append({"angle": angle, "turn_ns": round(spin, 1), "per_constant": round(spin / steady, 2),
                     "chain_ns": round(nanoseconds(chained, *arguments), 1),
                     "there_and_back": float(f"{min(np.abs(np.array(back) - sign * q).max() for sign in (1, -1)):.1e}")})
    print(json.dumps({"benchmark": "free_turning", "moments": options.moments, "turns": rows, **provenance()}))


if __name__ == "__main__":
    main()
