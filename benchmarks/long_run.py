"""What rounding does in a long run: energy, momentum, quaternions and the resolution of time after ever more collisions. One line of JSON.

    python benchmarks/long_run.py --semi-axes 1 1 2 --packing-fraction 0.50 -n 256 --collisions 1e8

After every tenth of the collisions the run is verified (overlaps, lists, calendar, predictions, energy).
"""

import argparse
import json
import time

import numpy as np
from provenance import provenance

import edmd


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=256)
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 2.0])
    parser.add_argument("--packing-fraction", type=float, default=0.50)
    parser.add_argument("--collisions", type=float, default=1e8)
    options = parser.parse_args()

    simulation = edmd.Simulation(edmd.random_system(options.n, options.semi_axes, options.packing_fraction, seed=1))
    energy, spent, means = simulation.energy, 0.0, []
    for _ in range(10):
        began = time.process_time()
        simulation.run(collisions=round(options.collisions / 10))
        spent += time.process_time() - began
        means.append(simulation.compressibility_factor)
        simulation.verify()
    system = simulation.system
    momentum = (system.masses[:, None] * system.velocities).sum(axis=0)
    thermal = np.sqrt((system.masses[:, None] ** 2 * system.velocities**2).sum(axis=1).mean())
    print(json.dumps({
        "benchmark": "long_run", "n": system.n, "semi_axes": options.semi_axes, "packing_fraction": options.packing_fraction,
        "collisions": simulation.collisions, "time": round(simulation.time, 3),
        "energy_change": float(f"{simulation.energy / energy - 1:.2g}"),
        "momentum_over_thermal": float(f"{np.linalg.norm(momentum) / thermal:.2g}"),
        "quaternions_off_unit": float(f"{abs(np.linalg.norm(system.orientations, axis=1) - 1).max():.2g}"),
        "compressibility_factor": [round(float(np.mean(means)), 4), float(f"{np.std(means, ddof=1) / np.sqrt(len(means)):.1g}")],
        "collisions_per_cpu_second": round(options.collisions / spent), **provenance()}))


if __name__ == "__main__":
    main()
