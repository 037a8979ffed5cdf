"""Examples 1 and 2 of the paper: CPU time and error of their solution at the minimal degree and at the paper's. One line of JSON.

    NUMBA_NUM_THREADS=1 python benchmarks/paper_examples.py

`intervals_ms`: from ellipsoids and motions to all intervals with their contact points, best of many; `first_contact_ms` likewise.
`error`: of Example 1's first contact, which is at t = 1/2 exactly. `degree_ratio`: how many times longer the same solution takes at the
paper's degree. `per_solve`: how many contact functions (ccd.batch.contact_function, one core, same run) take as long as the intervals.
"""

import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "examples"))

from equilibrium_speed import seconds_a_solve
from provenance import provenance

import ccd
from ccd_equation import example_1, example_2

ROUNDS, TIMES = 15, 60


def main():
    cases = {"example 1, [0, 1]": (*example_1(), (0, 1)), "example 1, [-2, 3]": (*example_1(), (-2, 3)),
             "example 2, [0, 1]": (*example_2(), (0, 1))}
    results = {}
    for name, case in cases.items():
        minimal, paper = ccd.CCDEquation(*case), ccd.CCDEquation(*case, degree="paper")
        intervals = best(lambda case=case: ccd.contact_intervals(*case))
        results[name] = {
            "degree": [minimal.minimal_degree_t, minimal.degree_t], "intervals_ms": round(1e3 * intervals, 4),
            "first_contact_ms": round(1e3 * best(lambda case=case: ccd.first_contact(*case)), 4),
            "overlaps": [overlaps(minimal), overlaps(paper)],
            "degree_ratio": round(best(paper.contact_intervals) / best(minimal.contact_intervals), 2),
            "per_solve": round(intervals / seconds_a_solve([1.0, 1.0, 2.0]))}
        if name == "example 1, [0, 1]":
            results[name]["error"] = [abs(equation.first_contact().time - 0.5) for equation in (minimal, paper)]
    print(json.dumps({"benchmark": "paper_examples", "paper_ms": {"example 1": 0.7, "example 2": 2.7}, "paper_error": 1e-8, **results,
                      **provenance()}))


def overlaps(equation):
    return sum(each.state == ccd.State.OVERLAPPING for each in equation.contact_intervals())


def best(question):
    spent = []
    for _ in range(ROUNDS):
        began = time.process_time()
        for _ in range(TIMES):
            question()
        spent.append((time.process_time() - began) / TIMES)
    return min(spent)


if __name__ == "__main__":
    main()
