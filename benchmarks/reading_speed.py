"""Megabytes per CPU second when the frames of a run are read one after the other through MDAnalysis. One line of JSON.

    python benchmarks/reading_speed.py -n 10000 --frames 200

What counts is what a frame has in the file: positions, velocities, orientations, angular velocities, semi-axes and images (140 bytes a
body; MDAnalysis asks for no moments of inertia). `of_plain` is the ratio to reading the same arrays with plain h5py, `of_stock` that to the
H5MD reader of MDAnalysis itself, both in the same run; the file is in the page cache for all three.
"""

import argparse
import json
import platform
import subprocess
import tempfile
import time
from pathlib import Path

import h5py
import MDAnalysis as mda
import numpy as np
from MDAnalysis.coordinates.H5MD import H5MDReader

import analysis  # noqa: F401  registers the file format
import edmd

ARRAYS = ("position", "velocity", "orientation", "angular_velocity", "semi_axes", "image")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=10_000)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.h5md"
        n = write(path, options.n, options.frames)
        megabytes = count_megabytes(path)
        ways = {"reader": read, "plain": read_plain, "stock": read_stock}
        seconds = {name: [] for name in ways}
        for _ in range(options.rounds):                         # in alternation: the machine's mood is shared
            for name, way in ways.items():
                began = time.process_time()
                way(path)
                seconds[name].append(time.process_time() - began)
    best = {name: min(values) for name, values in seconds.items()}
    print(json.dumps({
        "benchmark": "reading_speed", "n": n, "frames": options.frames, "megabytes": round(megabytes, 1),
        **{f"{name}_mb_per_second": round(megabytes / value) for name, value in best.items()},
        "of_plain": round(best["plain"] / best["reader"], 2), "of_stock": round(best["stock"] / best["reader"], 2),
        "machine": platform.processor() or platform.machine(),
        "commit": subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()}))


def write(path, n, frames):
    """A run of two frames of about n bodies as edmd writes it, then the first frame over and over. -> how many bodies."""
    cells = round((n / 4) ** (1 / 3))
    simulation = edmd.Simulation(edmd.lattice("fcc", (1.0, 1.0, 2.0), 0.3, cells=(cells, cells, cells)))
    with edmd.Trajectory(path) as trajectory:
        simulation.run(collisions=1, observers=[trajectory])
    with h5py.File(path, "a") as file:
        series = {}
        for group in ("particles/trajectory", "observables"):
            file[group].visititems(lambda name, thing: series.update({thing.id: thing}) if getattr(thing, "maxshape", (1,))[:1] == (None,)
                                   else None)
        for values in series.values():
            first = values[0]
            values.resize(frames, axis=0)
            for frame in range(frames):
                values[frame] = first
    return 4 * cells**3


def count_megabytes(path):
    with h5py.File(path, "r") as file:
        return sum(file[f"particles/trajectory/{name}/value"].nbytes for name in ARRAYS) / 1e6


def read(path):
    return sum(ts.positions[0, 0] for ts in mda.Universe(path).trajectory)


def read_plain(path):
    with h5py.File(path, "r") as file:
        arrays = [file[f"particles/trajectory/{name}/value"] for name in ARRAYS]
        return sum(np.sum([values[frame][0, 0] for values in arrays]) for frame in range(len(arrays[0])))


def read_stock(path):
    return sum(ts.positions[0, 0] for ts in H5MDReader(str(path)))


if __name__ == "__main__":
    main()
