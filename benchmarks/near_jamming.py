"""Collisions per CPU second close to jamming, beside those of the same bodies in the fluid. One line of JSON.

    python benchmarks/near_jamming.py --semi-axes 1 1 2 --pressure 1e6

The same bodies are measured at 0.50 and, compressed until the reduced pressure is that without growth; blocks of both in alternation.
"""

import argparse
import json
import time

import numpy as np
from provenance import provenance

import edmd


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=500)
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 2.0])
    parser.add_argument("--packing-fraction", type=float, default=0.50, help="of the fluid")
    parser.add_argument("--pressure", type=float, default=1e6, help="reduced, of the jammed")
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--collisions", type=int, default=200_000, help="in each of the blocks")
    parser.add_argument("--blocks", type=int, default=5)
    options = parser.parse_args()

    start = edmd.random_system(options.n, options.semi_axes, options.packing_fraction, seed=1)
    fluid, jammed = edmd.Simulation(start), edmd.Simulation(start)
    fluid.run(collisions_per_particle=100)
    goal = options.pressure
    while not jammed.compressibility_factor >= options.pressure:        # growing surfaces press harder than bodies at rest
        jammed.compress(options.rate, until_pressure=goal).run(collisions_per_particle=20)
        goal *= 3
    seconds = {"fluid": [], "jammed": []}
    for _ in range(options.blocks):
        for name, simulation in (("fluid", fluid), ("jammed", jammed)):
            began = time.process_time()
            simulation.run(collisions=options.collisions)
            seconds[name].append(time.process_time() - began)
    rates = {name: options.collisions / float(np.median(spent)) for name, spent in seconds.items()}
    print(json.dumps({
        "benchmark": "near_jamming", "n": options.n, "semi_axes": options.semi_axes, "fluid_fraction": options.packing_fraction,
        "jammed_fraction": round(jammed.packing_fraction, 6), "reduced_pressure": float(f"{jammed.compressibility_factor:.3g}"),
        "collisions_per_cpu_second_fluid": round(rates["fluid"]), "collisions_per_cpu_second_jammed": round(rates["jammed"]),
        "jammed_over_fluid": round(rates["jammed"] / rates["fluid"], 2), **provenance()}))


if __name__ == "__main__":
    main()
