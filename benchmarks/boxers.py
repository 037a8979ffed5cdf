"""CPU time of the first contact between two boxers, a frame of 400 pairs (the paper's Table 1). Single core. One line of JSON.

    NUMBA_NUM_THREADS=1 python benchmarks/boxers.py

`per_solve` compares a frame of setup 1 with the same run's own yardstick, which does not depend on the machine's mood: how many contact
functions (ccd.batch.contact_function, one core) take as long. The paper's figures, from another machine, stand beside ours.
"""

import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "examples"))

from equilibrium_speed import seconds_a_solve
from provenance import provenance

import boxers as example
from ccd.scene import Outcome
from figures.boxing import boxing

FRAMES = 1000


def main():
    groups = list(zip(*(example.frames(boxer) for boxer in boxing(FRAMES + 1))))
    solve = seconds_a_solve([1.0, 1.0, 2.0])
    frame = {name: example.solved(groups, setup).milliseconds for name, setup in example.SETUPS.items()}
    solve = min(solve, seconds_a_solve([1.0, 1.0, 2.0]))
    outcomes = example.solved(groups, example.CULLING).outcomes
    rigid, _, affine = (example.times_by_kind(groups, outcomes, setup) for setup in example.SETUPS.values())
    close = np.array([time for kind in example.CLOSE for time in rigid[kind].some])
    rounded = {name: round(value, 3) for name, value in frame.items()}
    print(json.dumps({
        "benchmark": "boxers", "frames": FRAMES, "pairs_a_frame": outcomes[0].size,
        "frame_ms": rounded, "paper_frame_ms": dict(zip(frame, (1.33, 1.90, 1.19))),
        "per_solve": round(1e-3 * frame["rigid motion, setup 1"] / solve, 1),
        "close_pair_us": round(example.mean(rigid, *example.CLOSE), 2), "close_pair_median_us": round(float(np.median(close)), 2),
        "close_pair_worst_us": round(close.max(), 2), "paper_close_pair_us": 55.2,
        "close_pair_affine_us": round(example.mean(affine, *example.CLOSE), 2),
        "outcomes": {kind.name: int((outcomes == kind).sum()) for kind in Outcome}, **provenance()}))


if __name__ == "__main__":
    main()
