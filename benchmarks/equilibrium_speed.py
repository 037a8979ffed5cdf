"""Collisions per CPU second in equilibrium, single core, after warm-up. One line of JSON.

    python benchmarks/equilibrium_speed.py --semi-axes 1 1 2 --packing-fraction 0.50 -n 2048
    python benchmarks/equilibrium_speed.py --all

--all takes a line for each state of STATES, with the speed wanted there and how much of it is reached.
`per_solve` compares with the same run's own yardstick, which does not depend on the machine's mood: how many pencil maximisations (one
contact function each, single core, random pairs of these bodies) take as long as one collision.
"""

import argparse
import json
import time

import numpy as np
from provenance import provenance

import ccd
import edmd
from ccd import batch
from edmd import state

STATES = [          # semi-axes, packing fraction, bodies, collisions per CPU second wanted
    ((1, 1, 2), 0.50, 2048, 350_000), ((1, 1.25, 1.5625), 0.50, 2048, 400_000), ((0.5, 0.5, 0.5), 0.45, 1372, 800_000),
    ((1, 1, 5), 0.40, 2048, 220_000), ((1, 1, 10), 0.25, 2048, 130_000), ((5, 5, 1), 0.40, 2048, 320_000)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=2048)
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 2.0])
    parser.add_argument("--packing-fraction", type=float, default=0.50)
    parser.add_argument("--collisions", type=int, default=300_000, help="in each of the blocks")
    parser.add_argument("--blocks", type=int, default=5)
    parser.add_argument("--melt", type=float, default=100.0, help="collisions per particle before the measurement")
    parser.add_argument("--all", action="store_true", help="every state of the table")
    options = parser.parse_args()
    if not options.all:
        print(json.dumps(measured(options)))
        return
    for options.semi_axes, options.packing_fraction, options.n, wanted in STATES:
        line = measured(options)
        print(json.dumps(line | {"wanted": wanted, "reached": round(line["collisions_per_cpu_second"] / wanted, 2)}), flush=True)


def measured(options):
    simulation = edmd.Simulation(edmd.random_system(options.n, options.semi_axes, options.packing_fraction, seed=1))
    simulation.run(collisions_per_particle=options.melt)
    rates, solves, before = [], [], simulation._world.tally.copy()
    for _ in range(options.blocks):
        began = time.process_time()
        simulation.run(collisions=options.collisions)
        rates.append(options.collisions / (time.process_time() - began))
        solves.append(seconds_a_solve(options.semi_axes))
    done = simulation._world.tally - before
    collisions = int(done[state.COLLISIONS])
    rate = float(np.median(rates))
    neighbours = float(simulation._world.lists.spans[:-1, state.COUNT].mean())
    return {
        "benchmark": "equilibrium_speed", "n": options.n, "semi_axes": options.semi_axes, "packing_fraction": options.packing_fraction,
        "collisions_per_cpu_second": round(rate), "fastest_block": round(max(rates)), "slowest_block": round(min(rates)),
        "per_solve": round(float(np.median(1 / np.array(rates) / np.array(solves))), 1),
        "solve_ns": round(1e9 * float(np.median(solves)), 1),
        "events": round(done[state.EVENTS] / collisions, 2), "looks": round(done[state.LOOKS] / collisions, 2),
        "rebuilds": round(done[state.REBUILDS] / collisions, 3), "neighbours": round(neighbours, 1),
        "compressibility_factor": round(simulation.compressibility_factor, 3), **provenance()}


def seconds_a_solve(semi_axes, pairs=20_000):
    """CPU time of one contact function, on one core."""
    import numba

    rng = np.random.default_rng(0)
    a = ccd.Bodies(semi_axes, np.zeros((pairs, 3)), rng.normal(size=(pairs, 4)))
    b = ccd.Bodies(semi_axes, 2 * max(semi_axes) * rng.normal(size=(pairs, 3)), rng.normal(size=(pairs, 4)))
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    batch.contact_function(a, b)
    began = time.process_time()
    batch.contact_function(a, b)
    spent = time.process_time() - began
    numba.set_num_threads(threads)
    return spent / pairs


if __name__ == "__main__":
    main()
