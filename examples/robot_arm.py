"""When does a robot arm collide with an obstacle? All intervals of 30 pairs of ellipsoids: Sec. 4.2 and Table 2 of the paper."""

import argparse
import time
from pathlib import Path
from typing import NamedTuple

import ccd
from figures import arm
from figures.drawing import moved, save_row, scene

ARM, OBSTACLE = (0.70, -0.03, -0.10), (0.84, 0.01, 0.10)        # OKLab
VIEW, PICTURE, FLOOR = (0.9, -1.0, 0.45), (215, 200), (0.24, 0, 0, 0.56)
INSTANTS = (0.0, 0.13, 0.33, 0.6, 0.82, 1.0)
REPEATS = 5


class Row(NamedTuple):
    """A row of the table. Times in milliseconds."""

    obstacle: str
    link: int
    motion_degree: int
    equation: ccd.CCDEquation
    obtain: float               # the equation
    solve: float                # all its intervals
    overlaps: list


def solved(names, pair):
    """The Row of a pair."""
    equation, obtain = milliseconds(ccd.CCDEquation, *pair)
    intervals, solve = milliseconds(equation.contact_intervals)
    overlaps = [each for each in intervals if each.state == ccd.State.OVERLAPPING]
    return Row(*names, getattr(pair[3], "degree", 0), equation, obtain, solve, overlaps)


def milliseconds(question, *arguments):
    """The answer, and the CPU time it takes, the best of a few."""
    best = float("inf")
    for _ in range(REPEATS):
        began = time.process_time()
        answer = question(*arguments)
        best = min(best, 1e3 * (time.process_time() - began))
    return answer, best


def print_table(rows):
    print("      Degree                    Time (ms)                  Collision intervals in [0, 1]\n"
          "      Motion  F in t  minimal   Obtain F   Solve   Total")
    for row in rows:
        found = ", ".join(f"[{each.start:.3f}, {each.end:.3f}]" for each in row.overlaps) or "-"
        print(f"{row.obstacle}-{row.link}   {row.motion_degree:6d}  {row.equation.degree_t:6d}  {row.equation.minimal_degree_t:7d}"
              f"   {row.obtain:8.3f}  {row.solve:6.3f}  {row.obtain + row.solve:6.3f}  {found}")
    print(f"all 30 pairs: {sum(row.obtain + row.solve for row in rows):.2f} ms (the paper: 43.8 ms)")


def draw(rows, path):
    """The arm at a few instants; what collides is red."""
    links, obstacles = [arm.ellipsoid(link) for link in arm.LINKS], list(arm.OBSTACLES.values())
    motions = [arm.motion(link) for link in arm.LINKS] + [ccd.Rest() for _ in obstacles]
    colours = [ARM] * len(links) + [OBSTACLE] * len(obstacles)
    pictures = []
    for t in INSTANTS:
        now = [row for row in rows if any(each.start <= t <= each.end for each in row.overlaps)]
        red = {row.link for row in now} | {len(links) + list(arm.OBSTACLES).index(row.obstacle) for row in now}
        pictures.append(scene(moved(links + obstacles, motions, t), colours, red, VIEW, PICTURE, FLOOR))
    save_row(pictures, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("robot_arm"), help="where the picture goes")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    rows = [solved(*pair) for pair in arm.pairs()]
    print_table(rows)
    draw(rows, options.folder / "robot_arm.png")
    print(f"\npicture  {options.folder / 'robot_arm.png'}")


if __name__ == "__main__":
    main()
