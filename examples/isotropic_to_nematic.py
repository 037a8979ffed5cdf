"""When do spheroids line up? A fluid of prolate spheroids is compressed step by step, from isotropic to nematic.

Near the transition the order fluctuates so slowly that blocks of one run cannot tell its error: independent runs do.
"""

import argparse
from pathlib import Path

import MDAnalysis as mda
import numpy as np
from matplotlib.image import imread

import analysis
import edmd
from analysis.style import BLUE, ORANGE, POINTS, letter_panels, panels, picture_panel

PACKING_FRACTIONS = [0.30, 0.34, 0.36, 0.38, 0.40, 0.42, 0.44, 0.47, 0.50]
RATE, FRAMES = 0.02, 50         # growth between two packing fractions; frames at each
PIXELS = (700, 700)


def compressed(options, seed):
    """Nematic order and P V / (n kT) at every packing fraction (m, 2), in one run; each has its own file."""
    results = []
    simulation = edmd.Simulation(edmd.random_system(options.n, (1.0, 1.0, options.aspect_ratio), PACKING_FRACTIONS[0], seed))
    for phi in PACKING_FRACTIONS:
        if phi > simulation.packing_fraction:
            simulation.compress(RATE, until_packing_fraction=phi)
        simulation.run(collisions_per_particle=options.collisions)                      # to equilibrium
        file = run_file(options, phi, seed)
        when = edmd.Every(collisions_per_particle=options.collisions / FRAMES)
        with edmd.Trajectory(file, when=when, overwrite=True) as trajectory:
            simulation.run(collisions_per_particle=options.collisions, observers=[trajectory])
        universe = mda.Universe(file)
        order = analysis.NematicOrder(universe.atoms).run().results.order.mean()
        universe.trajectory.close()
        results.append((order, analysis.mean_pressure(file)["reduced_pressure"][0]))
    return results


def run_file(options, packing_fraction, seed):
    return options.folder / f"run_{seed}_{packing_fraction:.2f}.h5md"


def draw(mean, error, pictures, n, output):
    """`mean` and `error` (m, 2): order and pressure; `pictures`: files of the first and the last packing fraction."""
    figure, grid = panels(2, 2, (7.6, 6.6))
    for axes, k, colour, label in ((grid[0, 0], 0, BLUE, "nematic order $S$"), (grid[0, 1], 1, ORANGE, "reduced pressure $PV/nkT$")):
        axes.errorbar(PACKING_FRACTIONS, mean[:, k], yerr=error[:, k], color=colour, **POINTS | {"fmt": "o-"})
        axes.set(xlabel=r"packing fraction $\phi$", ylabel=label)
    random = grid[0, 0].axhline(1 / np.sqrt(n), color="0.5", linewidth=0.9, linestyle="--")
    grid[0, 0].legend([random], [f"random: about $1/\\sqrt{{n}}$, $n = {n}$"], frameon=False)
    grid[0, 0].set_ylim(0, 1)
    letter_panels(figure)
    for axes, file, phi, letter in zip(grid[1], pictures, (PACKING_FRACTIONS[0], PACKING_FRACTIONS[-1]), "cd"):
        picture_panel(axes, imread(file))
        axes.set_title(f"({letter})  $\\phi = {phi:.2f}$", loc="left", fontsize=10)
    figure.savefig(output, dpi=200)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=108, help="bodies")
    parser.add_argument("--aspect-ratio", type=float, default=5.0)
    parser.add_argument("--collisions", type=float, default=400, help="per particle, to equilibrium and again to measure, at each step")
    parser.add_argument("--replicas", type=int, default=4, help="independent runs, at least 2")
    parser.add_argument("--folder", type=Path, default=Path("isotropic_to_nematic"), help="where the files go")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    results = np.array([compressed(options, seed) for seed in range(1, options.replicas + 1)])
    mean, error = results.mean(axis=0), results.std(axis=0, ddof=1) / np.sqrt(options.replicas)
    print("packing fraction     nematic order           PV/nkT")
    for phi, (order, pressure), (order_error, pressure_error) in zip(PACKING_FRACTIONS, mean, error):
        print(f"{phi:16.2f}   {order:.3f} +- {order_error:.3f}   {pressure:7.2f} +- {pressure_error:.2f}")
    pictures = [analysis.render(run_file(options, phi, seed=1), options.folder / f"{name}.png", size=PIXELS)
                for name, phi in (("first", PACKING_FRACTIONS[0]), ("last", PACKING_FRACTIONS[-1]))]
    figure = options.folder / "isotropic_to_nematic.png"
    draw(mean, error, pictures, options.n, figure)
    print(f"\nfigure  {figure}")


if __name__ == "__main__":
    main()
