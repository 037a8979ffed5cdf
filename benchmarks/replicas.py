"""Replicas in threads of one process: how their collisions a second scale with the cores (the engine lets go of the interpreter's lock).

    python benchmarks/replicas.py --threads 2

`scaling`: collisions per wall second of all threads over that of one, both measured in alternation; `cores_used`: CPU seconds per wall
second while they run, by one and by all: where others work too, that says what the machine gave. One line of JSON.
"""

import argparse
import json
import os
import threading
import time

import numpy as np
from provenance import provenance

import edmd


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("-n", type=int, default=500)
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 2.0])
    parser.add_argument("--packing-fraction", type=float, default=0.50)
    parser.add_argument("--collisions", type=int, default=200_000, help="of each replica in each of the blocks")
    parser.add_argument("--blocks", type=int, default=5)
    options = parser.parse_args()

    replicas = [edmd.Simulation(edmd.random_system(options.n, options.semi_axes, options.packing_fraction, seed=seed))
                for seed in range(options.threads)]
    for replica in replicas:
        replica.run(collisions_per_particle=50)
    one, all_of_them = [], []
    for _ in range(options.blocks):
        one.append(timed(replicas[:1], options.collisions))
        all_of_them.append(timed(replicas, options.collisions))
    alone, together = np.median(one, axis=0), np.median(all_of_them, axis=0)
    print(json.dumps({
        "benchmark": "replicas", "threads": options.threads, "cores": os.cpu_count(), "n": options.n,
        "collisions_per_second_one": round(options.collisions / alone[0]),
        "collisions_per_second_all": round(options.threads * options.collisions / together[0]),
        "scaling": round(options.threads * alone[0] / together[0], 2),
        "cores_used": [round(cpu / wall, 2) for wall, cpu in (alone, together)],
        "cpu_a_collision_relative_to_one": round(together[1] / options.threads / alone[1], 2), **provenance()}))


def timed(replicas, collisions):
    """Wall and CPU seconds in which every replica does so many collisions, each in a thread."""
    threads = [threading.Thread(target=replica.run, kwargs={"collisions": collisions}) for replica in replicas]
    wall, cpu = time.perf_counter(), time.process_time()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return time.perf_counter() - wall, time.process_time() - cpu


if __name__ == "__main__":
    main()
