"""How dense, and how well connected, are jammed packings of spheroids? Packing fraction and contact number against the aspect ratio."""

import argparse
from pathlib import Path

import numpy as np

import edmd
from analysis.style import BLUE, ORANGE, POINTS, letter_panels, panels

ASPECT_RATIOS = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 1.75, 2.0, 2.5]
UNTIL_PRESSURE = 1e6
ISOSTATIC = {"spheres": 6, "spheroids": 10}         # contacts a body = twice its degrees of freedom that contacts feel


def packed(aspect_ratio, n, rate, seeds):
    """Packing fractions and mean contact numbers of the held bodies (replicas, 2)."""
    packings = [edmd.pack(n, (1.0, 1.0, aspect_ratio), rate, seed, UNTIL_PRESSURE) for seed in seeds]
    return np.array([(each.packing_fraction, each.mean_contact_number) for each in packings])


def draw(aspect_ratios, results, output):
    """Means over the replicas with standard errors; `results` (aspect ratios, replicas, 2)."""
    mean, error = results.mean(axis=1), results.std(axis=1, ddof=1) / np.sqrt(results.shape[1])
    figure, (upper, lower) = panels(2, 1, (4.8, 5.6), sharex=True)
    for k, axes in enumerate((upper, lower)):
        axes.errorbar(aspect_ratios, mean[:, k], yerr=error[:, k], color=BLUE, **POINTS | {"fmt": "o-"})
        axes.axvline(1, color="0.7", linewidth=0.8, linestyle=":")
    upper.set(ylabel=r"packing fraction $\phi$")
    for name, number in ISOSTATIC.items():
        lower.axhline(number, color=ORANGE, linewidth=0.9, linestyle="--")
        lower.annotate(f"isostatic {name}", (max(aspect_ratios), number), (0, 3), textcoords="offset points", ha="right", fontsize=8,
                       color=ORANGE)
    lower.set(xlabel=r"aspect ratio $c/a$", ylabel="contacts a body $Z$", xscale="log", ylim=(5.5, 10.7))
    ticks = [0.4, 0.5, 0.7, 1.0, 1.5, 2.0, 2.5]
    lower.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    lower.set_xticks([], minor=True)
    letter_panels(figure)
    figure.savefig(output, dpi=200)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", type=int, default=125, help="bodies in a packing")
    parser.add_argument("--rate", type=float, default=1e-2, help="growth rate of the semi-axes")
    parser.add_argument("--replicas", type=int, default=3, help="packings at each aspect ratio, at least 2")
    parser.add_argument("--folder", type=Path, default=Path("packing_by_aspect_ratio"), help="where the figure goes")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    results = []
    print("aspect ratio  packing fractions, contacts a body")
    for aspect_ratio in ASPECT_RATIOS:
        results.append(packed(aspect_ratio, options.n, options.rate, range(1, options.replicas + 1)))
        print(f"{aspect_ratio:12g}  " + "   ".join(f"{phi:.4f}, {contacts:.2f}" for phi, contacts in results[-1]), flush=True)
    figure = options.folder / "packing_by_aspect_ratio.png"
    draw(ASPECT_RATIOS, np.array(results), figure)
    print(f"\nfigure  {figure}")


if __name__ == "__main__":
    main()
