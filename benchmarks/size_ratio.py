"""What a collision costs in a mixture of small bodies with a few ten times as long, against the small ones alone. One line of JSON."""

import argparse
import json
import time

from provenance import provenance

import edmd

LARGE, SMALL = (10.0, 10.0, 12.0), (1.0, 1.0, 1.2)


def microseconds(system, collisions, melt, blocks=4):
    """CPU time of a collision, in the fastest block."""
    simulation = edmd.Simulation(system)
    simulation.run(collisions_per_particle=melt)
    spent = []
    for _ in range(blocks):
        began = time.process_time()
        simulation.run(collisions=collisions)
        spent.append(time.process_time() - began)
    return 1e6 * min(spent) / collisions


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--large", type=int, default=6)
    parser.add_argument("--small", type=int, default=3000)
    parser.add_argument("--packing-fraction", type=float, default=0.35)
    parser.add_argument("--collisions", type=int, default=20_000, help="in each of the blocks")
    parser.add_argument("--melt", type=float, default=4.0, help="collisions per particle before the measurement")
    options = parser.parse_args()
    alone = microseconds(edmd.random_system(options.small, SMALL, options.packing_fraction, 1), options.collisions, options.melt)
    mixed = microseconds(edmd.random_system([options.large, options.small], [LARGE, SMALL], options.packing_fraction, 1),
                         options.collisions, options.melt)
    print(json.dumps({"benchmark": "size_ratio", "large": options.large, "small": options.small, "semi_axes": [LARGE, SMALL],
                      "packing_fraction": options.packing_fraction, "us_a_collision": round(mixed, 2), "small_alone_us": round(alone, 2),
                      "relative_cost": round(mixed / alone, 2), **provenance()}))


if __name__ == "__main__":
    main()
