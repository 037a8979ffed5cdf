"""How fast configurations are explored: mean squared displacement per CPU second, in units of V^(2/3), V the volume of one body.

    python benchmarks/exploring.py --semi-axes 1 1 2 --packing-fraction 0.50 -n 2048

Diffusion, not rattling: the growth of the mean squared displacement from one lag to twice that lag, by the CPU seconds that the lag takes,
over all pairs of blocks of a run in equilibrium. `with_rattling` is the displacement over the single lag by the same seconds. One line of
JSON.
"""

import argparse
import json
import time

import numpy as np
from provenance import provenance

import edmd


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=2048)
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 2.0])
    parser.add_argument("--packing-fraction", type=float, default=0.50)
    parser.add_argument("--lag", type=float, default=200.0, help="collisions per particle of a block")
    parser.add_argument("--blocks", type=int, default=12)
    parser.add_argument("--melt", type=float, default=200.0, help="collisions per particle before the measurement")
    options = parser.parse_args()

    simulation = edmd.Simulation(edmd.random_system(options.n, options.semi_axes, options.packing_fraction, seed=1))
    simulation.run(collisions_per_particle=options.melt)
    places, seconds, began = [unwrapped(simulation)], [], simulation.time
    for _ in range(options.blocks):
        started = time.process_time()
        simulation.run(collisions_per_particle=options.lag)
        seconds.append(time.process_time() - started)
        places.append(unwrapped(simulation))
    places = np.array(places)
    one, two = (((places[lag:] - places[:-lag])**2).sum(axis=2).mean() for lag in (1, 2))
    unit = (4 * np.pi / 3 * np.prod(options.semi_axes)) ** (2 / 3)
    lag_seconds = float(np.median(seconds))
    diffusion = (two - one) / 6 / (simulation.time - began) * options.blocks
    print(json.dumps({
        "benchmark": "exploring", "n": options.n, "semi_axes": options.semi_axes, "packing_fraction": options.packing_fraction,
        "msd_per_cpu_second": round((two - one) / unit / lag_seconds, 3), "with_rattling": round(one / unit / lag_seconds, 3),
        "msd_of_a_lag": round(one / unit, 3), "diffusion_coefficient": round(diffusion, 5),
        "collisions_per_cpu_second": round(options.lag * options.n / 2 / lag_seconds), **provenance()}))


def unwrapped(simulation):
    """Positions as if there were no cell, without the drift of them all."""
    system, images = simulation.synchronised()
    positions = system.positions + images @ system.box
    return positions - positions.mean(axis=0)


if __name__ == "__main__":
    main()
