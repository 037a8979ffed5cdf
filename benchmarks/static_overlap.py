"""How long does it take to tell the state of two ellipsoids at rest, and how near to touching is it right? One core; one line of JSON.

    python benchmarks/static_overlap.py

Three mixes of pairs, from semi-axes, centres and quaternions as `ccd.Bodies` holds them. near: semi-axes 0.5 to 2, distances 0.7 to 1.3 of
that at which they would touch, so that half are separate and none trivially. long: the same with needles 1:1:100, plates 100:100:1 and
both. alike: equal parallel ellipsoids, whose Sturm sequences degenerate, so that every pair needs the contact function. `second_looks`
is the share of pairs that do. `worst_sign` is the largest |f - 1| found at which the state is not the sign of f - 1, by Sturm sequences in
fifty digits, over pairs with |f - 1| between 1e-14 and 1e-9: TOUCHING begins at 1e-12. Ratios are to numpy's time for f at one lambda.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

os.environ["NUMBA_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "oracles"))

import numpy as np
import roots
from provenance import provenance

import ccd
from ccd.characteristic import UNCERTAIN, magnitudes, margin, polynomial, state_by_roots
from ccd.overlap import _pose
from ccd.quaternions import rotation_matrices


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=124_000)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--hard", type=int, default=300, help="pairs of each mix that are judged in fifty digits")
    options = parser.parse_args()
    mixes = {}
    for name, axes in (("near", near), ("long", long), ("alike", alike)):
        a, b = touching(*axes(np.random.default_rng(0), options.pairs))
        rng = np.random.default_rng(1)
        mixed = moved(a, b, rng.uniform(0.7, 1.3, options.pairs))
        asked = {"state": ccd.batch.state, "contact_function": ccd.batch.contact_function, "numpy": f_at_one_half}
        ns = {question: 1e9 * seconds / options.pairs for question, seconds in fastest(asked, mixed, options.repeats).items()}
        mixes[name] = {
            "state_ns": round(ns["state"], 1), "contact_function_ns": round(ns["contact_function"], 1),
            "state_over_numpy": round(ns["state"] / ns["numpy"], 4),
            "contact_function_over_numpy": round(ns["contact_function"] / ns["numpy"], 4),
            "separate": round(float((ccd.batch.state(*mixed) > 0).mean()), 3), "second_looks": second_looks(*mixed),
            "worst_sign": worst_sign(a, b, 10.0 ** rng.uniform(-14, -9, options.hard) * rng.choice([-1, 1], options.hard))}
    pair = one(*mixed, 0)
    single = fastest({"state": thousand_times(ccd.state), "separation": thousand_times(ccd.separation)}, pair, options.repeats)
    print(json.dumps({
        "benchmark": "static_overlap", "pairs": options.pairs, **mixes,
        "single_us": {question: round(1e3 * seconds, 2) for question, seconds in single.items()},
        **provenance()}))


def near(rng, n):
    return bodies(rng, rng.uniform(0.5, 2, (n, 3))), bodies(rng, rng.uniform(0.5, 2, (n, 3)))


def long(rng, n):
    needle, plate = np.array([0.01, 0.01, 1]), np.array([1, 1, 0.01])
    return tuple(bodies(rng, np.where(rng.random((n, 1)) < 0.5, needle, plate)) for _ in range(2))


def alike(rng, n):
    a = bodies(rng, rng.uniform(0.5, 2, (n, 3)))
    return a, a


def bodies(rng, semi_axes):
    return ccd.Bodies(semi_axes, np.zeros_like(semi_axes), rng.normal(size=(len(semi_axes), 4)))


def touching(a, b):
    """A at the origin, B in some direction where it touches A."""
    away = np.random.default_rng(2).normal(size=(len(a), 3))
    f = ccd.batch.contact_function(a, ccd.Bodies(b.semi_axes, away, b.orientation))
    return a, ccd.Bodies(b.semi_axes, away / np.sqrt(f)[:, None], b.orientation)


def moved(a, b, factor):
    return a, ccd.Bodies(b.semi_axes, b.center * factor[:, None], b.orientation)


def one(a, b, k):
    return tuple(ccd.Ellipsoid(body.semi_axes[k], body.center[k], body.orientation[k]) for body in (a, b))


def thousand_times(question):
    return lambda a, b: [question(a, b) for _ in range(1000)]


def fastest(questions, pair, repeats):
    """CPU seconds of each, the best of some, asked in turn."""
    best = dict.fromkeys(questions, np.inf)
    for repeat in range(repeats + 1):
        for name, ask in questions.items():
            began = time.process_time()
            ask(*pair)
            if repeat:                                          # the first time compiles
                best[name] = min(best[name], time.process_time() - began)
    return best


def f_at_one_half(a, b):
    """The yardstick: r^T (X_A + X_B)^-1 r / 2 of all pairs, in plain numpy."""
    shapes = []
    for body in (a, b):
        vectors = rotation_matrices(body.orientation) * body.semi_axes[:, None, :]
        shapes.append(vectors @ vectors.transpose(0, 2, 1))
    r = b.center - a.center
    return 0.5 * np.einsum("ni,ni->n", r, np.linalg.solve(shapes[0] + shapes[1], r[:, :, None])[:, :, 0])


def second_looks(a, b, sample=5000):
    def uncertain(pair):
        g, t, det = _pose(*pair)
        aspect = pair[1].semi_axes.max() / pair[1].semi_axes.min()
        return state_by_roots(polynomial(g, t, det), magnitudes(g, t), margin(aspect)) == UNCERTAIN
    return float(np.mean([uncertain(one(a, b, k)) for k in range(sample)]))


def worst_sign(a, b, excess):
    worst = 0.0
    for k, factor in enumerate(np.sqrt(1 + excess)):
        pair = one(a, b, k)
        pair = pair[0], ccd.Ellipsoid(pair[1].semi_axes, pair[1].center * factor, pair[1].orientation)
        maps = [(body.semi_axes, roots.rigid_map(body.orientation, body.center)) for body in pair]
        separate = roots.distinct_negative_roots(roots.characteristic_polynomial(*maps[0], *maps[1])) == 2
        if ccd.state(*pair) != (1 if separate else -1):
            worst = max(worst, abs(ccd.separation(*pair).contact_function - 1))
    return float(f"{worst:.2g}")


if __name__ == "__main__":
    main()
