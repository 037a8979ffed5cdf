"""A million bodies: start from a lattice, a million collisions, a frame on disk; time and peak memory. One line of JSON.

    python benchmarks/million.py

The yardstick of the same run is a small system of the same kind: CPU time of one of its collisions.
"""

import argparse
import json
import tempfile
import time
from math import ceil
from pathlib import Path

import numpy as np
from provenance import provenance
from system_size import peak, warm_up

import edmd


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=1_000_000)
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 2.0])
    parser.add_argument("--packing-fraction", type=float, default=0.50)
    parser.add_argument("--collisions", type=int, default=1_000_000)
    options = parser.parse_args()

    warm_up(options.semi_axes)
    small = edmd.Simulation(edmd.lattice("fcc", options.semi_axes, options.packing_fraction, (8, 8, 8), stretched=True))
    small.run(collisions_per_particle=10)
    began = time.process_time()
    small.run(collisions=100_000)
    yardstick = (time.process_time() - began) / 100_000
    del small

    wall, steps = time.perf_counter(), {}

    def step(name, action):
        began = time.process_time()
        result = action()
        steps[name] = round(time.process_time() - began, 1)
        return result

    cells = np.full(3, ceil((options.n / 4) ** (1 / 3)))
    while 4 * cells[0] * cells[1] * (cells[2] - 1) >= options.n:
        cells[2] -= 1
    start = step("lattice", lambda: edmd.lattice("fcc", options.semi_axes, options.packing_fraction, tuple(map(int, cells)), seed=1,
                                                 stretched=True))
    simulation = step("simulation", lambda: edmd.Simulation(start))
    step("collisions", lambda: simulation.run(collisions=options.collisions))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frame.h5md"

        def frame():
            with edmd.Trajectory(path, edmd.Every(collisions=1)) as trajectory:
                simulation.run(collisions=1, observers=[trajectory])
        step("frame", frame)
        size = path.stat().st_size
    print(json.dumps({"benchmark": "million", "n": start.n, "semi_axes": options.semi_axes, "packing_fraction": options.packing_fraction,
                      "collisions": simulation.collisions, "cpu_seconds": steps, "wall_seconds": round(time.perf_counter() - wall, 1),
                      "peak_gb": round(peak() / 1e9, 2), "frame_mb": round(size / 1e6, 1),
                      "collision_relative_to_2048": round(steps["collisions"] / options.collisions / yardstick, 2), **provenance()}))


if __name__ == "__main__":
    main()
