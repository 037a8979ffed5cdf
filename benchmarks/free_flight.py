"""First contact of two ellipsoids in free flight: nanoseconds a query. One line of JSON.

    python benchmarks/free_flight.py --pairs 4300

Three mixes. hard: half pairs that come near each other (semi-axes log-uniform in 0.15 to 3, 6 apart, spins up to 12 rad a window; about
half of them touch), half pairs that graze, at touching scales of 1 +- 1e-3, 1e-5 and 1e-7. easy: the first kind only, with semi-axes 0.5 to
2 and spins up to 3 rad. trial: as hard, with spins uniform in a ball of 6 rad.
All flights are made by the tests' oracles. Times are CPU times on one core after warm-up, the best of several; `median_ns` is over
queries each timed by itself, in a batch of many copies, with all that it costs to call one. `per_solve`: how many contact functions
(`ccd.batch.contact_function`, same pairs, one core, same run) take as long as a mean query. `parallel_ns`: wall time a query on all cores.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numba
import numpy as np

sys.path[:0] = [str(Path(__file__).parent.parent / folder) for folder in ("tests/oracles", "tests/ccd", ".")]

import dense  # noqa: E402
from pairs import bodies, directions, joined, meeting, single  # noqa: E402
from provenance import provenance  # noqa: E402

import ccd  # noqa: E402
from ccd import Status  # noqa: E402

DEPTHS = [sign * depth for depth in (1e-3, 1e-5, 1e-7) for sign in (1, -1)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=4300)
    parser.add_argument("--seed", type=int, default=2009)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    mixes = {"hard": hard(rng, options.pairs), "easy": meeting(rng, options.pairs, (0.5, 2), 3),
             "trial": hard(rng, options.pairs, in_a_ball)}
    print(json.dumps({"benchmark": "free_flight", "pairs": options.pairs, **{name: figures(*mix) for name, mix in mixes.items()},
                      "threads": numba.get_num_threads(), **provenance()}))


def hard(rng, pairs, made=meeting):
    one, other = made(rng, pairs // 2)
    a, b = made(rng, pairs // (2 * len(DEPTHS)))
    at_zero, _ = dense.graze(a, b, 1.0, np.zeros(len(a)), rounds=8)
    grazing = [dense.graze(a, at_zero, 1.0, np.full(len(a), depth), rounds=3, samples=150)[0] for depth in DEPTHS]
    return joined(one, *[a] * len(DEPTHS)), joined(other, *grazing)


def in_a_ball(rng, pairs):
    flights = meeting(rng, pairs)
    for each in flights:
        each.angular_velocity[:] = 6 * directions(rng, pairs) * rng.uniform(0, 1, (pairs, 1))**(1 / 3)
    return flights


def figures(a, b):
    pair = bodies(a), bodies(b)
    _, status = ccd.batch.first_contact(*pair)
    parallel = best(time.perf_counter, lambda: ccd.batch.first_contact(*pair), 10) / len(a)
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    serial, solve = (best(time.process_time, lambda question=question: question(*pair), 15) / len(a)
                     for question in (ccd.batch.first_contact, ccd.batch.contact_function))
    each = [seconds_alone(a, b, k) for k in range(0, len(a), max(len(a) // 400, 1))]
    numba.set_num_threads(threads)
    steps = [ccd.first_contact(*single(a, k), *single(b, k)).iterations for k in range(len(a))]
    return {"mean_ns": round(1e9 * serial), "median_ns": round(1e9 * float(np.median(each))), "per_solve": round(serial / solve, 1),
            "solve_ns": round(1e9 * solve), "parallel_ns": round(1e9 * parallel), "steps": round(float(np.mean(steps)), 2),
            "contacts": round(float((status == Status.CONTACT).mean()), 3),
            "unresolved": round(float((status == Status.UNRESOLVED).mean()), 6)}


def seconds_alone(a, b, k, times=1000):
    again = np.full(times, k)
    pair = bodies(a.pick(again)), bodies(b.pick(again))
    return best(time.process_time, lambda: ccd.batch.first_contact(*pair), 2) / times


def best(clock, question, rounds):
    spent = []
    for _ in range(rounds):
        began = clock()
        question()
        spent.append(clock() - began)
    return min(spent)


if __name__ == "__main__":
    main()
