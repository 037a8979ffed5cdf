"""The CCD equation F(u, t) = 0 of two moving ellipsoids, its zero set and its intervals: Examples 1 and 2 of the paper (Sec. 4.3).

F(u, t) > 0 for some u in (0, 1) means: separate at time t. Where no u does it, the bodies overlap.
"""

import argparse
import time
from pathlib import Path

import matplotlib
import numpy as np
from scipy.interpolate import BPoly
from scipy.optimize import brentq, minimize_scalar

import ccd
from analysis.style import letter_panels
from figures.drawing import moved, save_row, scene

ROOT2 = np.sqrt(2)
SEPARATE, CRITICAL, SHOOT = "#cfe0f2", "#c81e1e", "#b36b00"
ARROW = {"arrowstyle": "-|>", "color": SHOOT, "shrinkA": 0, "shrinkB": 0, "linewidth": 1.3}
BODIES = ((0.68, -0.03, -0.10), (0.86, 0.01, 0.10))         # OKLab
INSTANTS = (0.0, 0.04, 0.15, 0.31, 0.5, 0.69, 0.86)
VIEW, PICTURE, FLOOR = (0.3, -1.0, 0.5), (220, 165), (0, 0, -2, 4)


def example_1():
    """Example 1 of the paper, which prints the rotation matrices; from them these Euler parameters. First contact at t = 1/2."""
    a, b = ccd.Ellipsoid((2, 4, 2)), ccd.Ellipsoid((1, 3, 4))
    turn_a = [[1, 0], [0, 0], [-1, 2], [-1, 2]]
    path_a = [[-2, -6, 24, -8], [-6, 6, 24, -24], [-2, -12, 48, -32]]
    turn_b = [[-1, 2], [1, ROOT2], [1 + ROOT2, -2 - 2 * ROOT2], [-1 - ROOT2, 2 + ROOT2]]
    path_b = [[-27 + 24 * ROOT2, 114 - 72 * ROOT2, -156 + 72 * ROOT2, 72 - 24 * ROOT2], [-6, 12, 0, 0],
              [-26 + 24 * ROOT2, 114 - 72 * ROOT2, -168 + 72 * ROOT2, 88 - 24 * ROOT2]]
    return a, ccd.RationalMotion(turn_a, path_a), b, ccd.RationalMotion(turn_b, path_b)


def example_2():
    """Two unit spheres under affine motions of degree 4, as the paper's Example 2, whose motion it does not give.

    Both become ellipsoids and change their shapes all the time. B swings through A four times, along 3 T4(2 t - 1) in x, where T4 is the
    fourth Chebyshev polynomial.
    """
    zero = [0, 0, 0, 0, 0]
    linear_a = [[[0.6, 1.6, 0, 0, -0.8], zero, zero],
                [[0, 1.5, 0, 0, -1.5], [1.6, -2, 0, 0, 1.2], zero],
                [zero, zero, [0.8, 0, 0, 0, 0.4]]]
    linear_b = [[[0.9, 0, -1.6, 0, 1.2], [0, -0.8, 0, 0, 0.8], zero],
                [zero, [0.8, 1, 0, 0, -0.8], zero],
                [zero, [-0.5, 0, 0, 0, 1], [1.2, -0.8, 0, 0, 0.4]]]
    path_b = [[3, -96, 480, -768, 384], [0.5, 0, -1, 0, 0], [-0.3, 0, 0, 0, 0.6]]
    sphere = ccd.Ellipsoid((1, 1, 1))
    return sphere, ccd.AffineMotion(linear_a, np.zeros((3, 1))), sphere, ccd.AffineMotion(linear_b, path_b)


def on_grid(equation, u, t):
    """F at all times t (T,) and all u (U,): (T, U). At the minimal degree, which differs from the paper's F by a positive factor."""
    rows = BPoly(equation.minimal.T[:, None], equation.t_span)(t)
    return rows @ [choose * u**i * (1 - u)**(4 - i) for i, choose in enumerate((1, 4, 6, 4, 1))]


def best_u(equation, t):
    """The u that maximises F(u, t), and that maximum."""
    found = minimize_scalar(lambda u: -on_grid(equation, np.array([u]), [t])[0, 0], bounds=(0, 1), options={"xatol": 1e-10})
    return found.x, -found.fun


def shoot(equation, start, end):
    """A Bézier shoot from `start` towards `end`: the best u at the start, and how far F(u, t) > 0 holds. -> u, time."""
    u, _ = best_u(equation, start)
    times = np.linspace(start, end, 2001)
    closed = np.flatnonzero(on_grid(equation, np.array([u]), times[1:]) <= 0)
    if len(closed) == 0:
        return u, end
    return u, brentq(lambda t: on_grid(equation, np.array([u]), [t])[0, 0], *times[closed[0]:closed[0] + 2], xtol=1e-15)


def recursive_shoots(equation, start, end, most=8):
    """Shoots from `start` towards `end`, each from where the last one came to, until they no longer move. -> [(u, from, to), ...]"""
    steps = []
    while len(steps) < most and start != end and best_u(equation, start)[1] > 0:
        u, reached = shoot(equation, start, end)
        steps.append((u, start, reached))
        if abs(reached - start) < 1e-9:
            break
        start = reached
    return steps


def draw(axes, equation, intervals, shoots):
    """The zero set of F, u to the right and t up; overlapping intervals beside it; critical points and Bézier shoots."""
    low, high = equation.t_span
    u, t = np.linspace(0, 1, 401), np.linspace(low, high, 1201)
    F = on_grid(equation, u, t)
    F /= np.abs(F).max(axis=1, keepdims=True)
    axes.contourf(u, t, F, levels=[0, 1], colors=[SEPARATE])
    axes.contour(u, t, F, levels=[0], colors="black", linewidths=1)
    for x, start, end in shoots:
        axes.annotate("", (x, end), (x, start), arrowprops=ARROW)
    overlaps = [interval for interval in intervals if interval.state == ccd.State.OVERLAPPING]
    for interval in overlaps:
        axes.plot([1.04, 1.04], [interval.start, interval.end], color=CRITICAL, linewidth=4, solid_capstyle="butt", clip_on=False)
    critical = [end for interval in overlaps for end in (interval.start, interval.end) if low < end < high]
    axes.plot([best_u(equation, end)[0] for end in critical], critical, "o", color=CRITICAL, markersize=4)
    axes.set(xlabel="$u$", ylabel="$t$", xlim=(0, 1), ylim=(low, high))


def solved(equation):
    """The intervals of an equation, printed with the time that they take, the best of ten."""
    seconds = []
    for _ in range(10):
        began = time.process_time()
        intervals = equation.contact_intervals()
        seconds.append(time.process_time() - began)
    low, high = equation.t_span
    overlaps = [f"[{each.start:.10f}, {each.end:.10f}]" for each in intervals if each.state == ccd.State.OVERLAPPING]
    print(f"  t in [{low:g}, {high:g}]: overlapping in {', '.join(overlaps)}   ({1e3 * min(seconds):.3f} ms)")
    return intervals


def portrait(bodies, t):
    """The two bodies at time t, red when they overlap."""
    a, motion_a, b, motion_b = bodies
    overlap = best_u(ccd.CCDEquation(*bodies), t)[1] < 0
    return scene(moved((a, b), (motion_a, motion_b), t), BODIES, (0, 1) if overlap else (), VIEW, PICTURE, FLOOR)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("ccd_equation"), help="where the pictures go")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    zero_sets, bodies = options.folder / "zero_sets.png", options.folder / "affine_pair.png"
    figure, panels = plt.subplots(1, 3, figsize=(10, 4), layout="constrained")
    for axes, name, pair, t_span, shoots in ((panels[0], "Example 1", example_1(), (0, 1), [(0, 1)]),
                                             (panels[1], "Example 1", example_1(), (-2, 3), []),
                                             (panels[2], "Example 2", example_2(), (0, 1), [(0.55, 1), (0.55, 0)])):
        equation = ccd.CCDEquation(*pair, t_span)
        contact = equation.first_contact()
        print(f"{name}: F has degree {equation.degree_t} in t, {equation.minimal_degree_t} without common factors")
        draw(axes, equation, solved(equation), [step for start, end in shoots for step in recursive_shoots(equation, start, end)])
        print(f"  first contact at t = {contact.time:.15g}, at {np.round(contact.point, 12)}")
        axes.set_title(f"{name}, $t \\in [{t_span[0]}, {t_span[1]}]$", fontsize=10)
    figure.get_layout_engine().set(wspace=0.12)             # for the bars beside the panels
    letter_panels(figure)
    figure.savefig(zero_sets, dpi=200)
    save_row([portrait(example_2(), t) for t in INSTANTS], bodies)
    print(f"\nzero sets  {zero_sets}\nbodies     {bodies}")


if __name__ == "__main__":
    main()
