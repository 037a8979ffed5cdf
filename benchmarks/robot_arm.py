"""CPU time of all collision intervals of a robot arm and an obstacle: the 30 pairs of the paper's Table 2. Single core. One line of JSON.

    NUMBA_NUM_THREADS=1 python benchmarks/robot_arm.py

`per_solve` compares with the same run's own yardstick, which does not depend on the machine's mood: how many contact functions
(ccd.batch.contact_function, one core) take as long as the 30 pairs. `paper_ms` is what the paper measured on another machine.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "examples"))

from equilibrium_speed import seconds_a_solve
from provenance import provenance

import ccd
from figures import arm

ROUNDS = 40


def main():
    pairs = [pair for _, pair in arm.pairs()]
    obtain, solve, yardstick = [], [], []
    for _ in range(ROUNDS):
        began = time.process_time()
        equations = [ccd.CCDEquation(*pair) for pair in pairs]
        halfway = time.process_time()
        intervals = [equation.contact_intervals() for equation in equations]
        obtain.append(halfway - began)
        solve.append(time.process_time() - halfway)
        yardstick.append(seconds_a_solve([1.0, 1.0, 2.0]))
    total = np.array(obtain) + solve
    print(json.dumps({
        "benchmark": "robot_arm", "pairs": len(pairs), "total_ms": round(1e3 * total.min(), 3),
        "median_ms": round(1e3 * np.median(total), 3),
        "obtain_F_ms": round(1e3 * min(obtain), 3), "solve_ms": round(1e3 * min(solve), 3), "paper_ms": 43.8,
        "per_solve": round(float(np.median(total / yardstick))),
        "overlapping_intervals": sum(each.state == ccd.State.OVERLAPPING for found in intervals for each in found), **provenance()}))


if __name__ == "__main__":
    main()
