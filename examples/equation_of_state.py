"""The pressure of a fluid of hard spheres, with error bars by blocks, against two formulas."""

import argparse
from pathlib import Path

import numpy as np
from numpy.polynomial.polynomial import polyval

import analysis
import edmd
from analysis.style import BLUE, GREEN, ORANGE, POINTS, letter_panels, panels

PACKING_FRACTIONS = [0.05, 0.10, 0.15, 0.20, 0.25, 0.30, 0.35, 0.40, 0.45, 0.48]
MELT, BLOCKS = 100, 64              # collisions per particle before the measurement; blocks that are measured


def carnahan_starling(phi):
    """P V / (n kT) of hard spheres at packing fraction phi (Carnahan and Starling, J. Chem. Phys. 51, 635 (1969))."""
    return (1 + phi + phi**2 - phi**3) / (1 - phi) ** 3


def kolafa(phi):
    """The same, fitted to molecular dynamics (Kolafa, Labik and Malijevsky, Phys. Chem. Chem. Phys. 6, 2335 (2004))."""
    return polyval(phi / (1 - phi), [1, 4, 6, 2.3647684, -0.8698551, 1.1062803, -1.095049, 0.637614, -0.2279397, 0.1098948, -0.00906797])


def measured(packing_fraction, cells, collisions_per_particle, seed):
    """P V / (n kT) and its standard error."""
    simulation = edmd.Simulation(edmd.lattice("fcc", (0.5, 0.5, 0.5), packing_fraction, cells, seed))
    simulation.run(collisions_per_particle=MELT)
    block = collisions_per_particle / simulation.collision_rate / BLOCKS
    pressures = []
    for _ in range(BLOCKS):
        simulation.run(time=block)
        pressures.append(simulation.compressibility_factor)
    return np.mean(pressures), analysis.block_error(pressures)


def draw(phi, pressure, error, output):
    figure, (left, right) = panels(1, 2, (8.4, 3.5))
    line = np.linspace(0, 0.5, 200)
    left.plot(line, carnahan_starling(line), color=ORANGE, label="Carnahan and Starling")
    left.errorbar(phi, pressure, yerr=error, color=BLUE, label="events", **POINTS)
    left.set(xlabel=r"packing fraction $\phi$", ylabel="reduced pressure $PV/nkT$", xlim=(0, 0.5), ylim=(0, None))
    left.legend(frameon=False)
    theory = carnahan_starling(phi)
    right.axhline(0, color=ORANGE)
    right.plot(line, 100 * (kolafa(line) / carnahan_starling(line) - 1), color=GREEN, label="Kolafa et al.")
    right.legend(frameon=False, loc="lower left")
    right.errorbar(phi, 100 * (pressure / theory - 1), yerr=100 * error / theory, color=BLUE, **POINTS)
    right.set(xlabel=r"packing fraction $\phi$", ylabel="deviation from C. and S. (%)", xlim=(0, 0.5))
    widest = max(abs(value) for value in right.get_ylim())
    right.set_ylim(-widest, widest)
    letter_panels(figure)
    figure.savefig(output, dpi=200)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=6, help="unit cells a side: 4 cells^3 spheres")
    parser.add_argument("--collisions", type=float, default=600, help="per particle, at each packing fraction")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("equation_of_state"), help="where the figure goes")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    phi, results = np.array(PACKING_FRACTIONS), []
    print("packing fraction      PV/nkT             Carnahan and Starling")
    for each in phi:
        pressure, error = measured(each, (options.cells,) * 3, options.collisions, options.seed)
        results.append((pressure, error))
        print(f"{each:16.2f}   {pressure:8.4f} +- {error:.4f}   {carnahan_starling(each):8.4f}", flush=True)
    figure = options.folder / "equation_of_state.png"
    draw(phi, *np.array(results).T, figure)
    print(f"\nfigure  {figure}")


if __name__ == "__main__":
    main()
