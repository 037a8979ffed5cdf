"""Cost of a collision, and memory of a body, against the number of bodies: equilibrium, single core, CPU time. One line of JSON.

    python benchmarks/system_size.py --semi-axes 1 1 2 --packing-fraction 0.50 --cells 8 16 32

4 cells^3 bodies on a stretched fcc lattice melt first. Each size runs in a process of its own: `bytes_a_body` is by how much its resident
memory grows from before the Simulation is made to after the run, with what is freed given back to the system (glibc would keep up to
64 MB). `relative_cost` is that of the smallest system, within the same minutes.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import time

from provenance import provenance

import edmd


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 2.0])
    parser.add_argument("--packing-fraction", type=float, default=0.50)
    parser.add_argument("--cells", type=int, nargs="+", default=[8, 16, 32], help="unit cells along each edge")
    parser.add_argument("--collisions", type=int, default=300_000, help="in each of the blocks")
    parser.add_argument("--blocks", type=int, default=3)
    parser.add_argument("--melt", type=float, default=20.0, help="collisions per particle before the measurement")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one is not None:
        print(json.dumps(measured(options)))
        return
    sizes = []
    for cells in options.cells:
        done = subprocess.run([sys.executable, *sys.argv, "--one", str(cells)], stdout=subprocess.PIPE, text=True, check=True,
                              env=os.environ | dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), "1048576"))
        sizes.append(json.loads(done.stdout))
    for size in sizes:
        size["relative_cost"] = round(size["us_a_collision"] / sizes[0]["us_a_collision"], 2)
    print(json.dumps({"benchmark": "system_size", "semi_axes": options.semi_axes, "packing_fraction": options.packing_fraction,
                      "sizes": sizes, **provenance()}))


def measured(options):
    warm_up(options.semi_axes)
    start = edmd.lattice("fcc", options.semi_axes, options.packing_fraction, (options.one,) * 3, seed=1, stretched=True)
    before = resident()
    simulation = edmd.Simulation(start)
    simulation.run(collisions_per_particle=options.melt)
    spent = []
    for _ in range(options.blocks):
        began = time.process_time()
        simulation.run(collisions=options.collisions)
        spent.append((time.process_time() - began) / options.collisions)
    return {"n": start.n, "us_a_collision": round(1e6 * min(spent), 3), "slowest_block": round(1e6 * max(spent), 3),
            "bytes_a_body": round((resident() - before) / start.n), "bytes_a_body_at_most": round((peak() - before) / start.n)}


def warm_up(semi_axes):
    """What the first simulation of a process costs, compiled code and libraries, is not a matter of its size."""
    edmd.Simulation(edmd.lattice("fcc", semi_axes, 0.3, (3, 3, 3), stretched=True)).run(collisions=1000)


def resident():
    """Bytes of memory in use now."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def peak():
    """Bytes of memory in use at most so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


if __name__ == "__main__":
    main()
