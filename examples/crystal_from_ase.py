"""A crystal of ellipsoids that ASE builds: does it hold, and at which density does it melt?

The crystal is SM2 of Donev, Stillinger, Chaikin and Torquato (Phys. Rev. Lett. 92, 255506 (2004)): layers of spheroids of aspect ratio
sqrt(3), turned by 90 degrees from one layer to the next; at 0.7707 denser than any packing of spheres. It is expanded step by step. The
height of its Bragg peak says how much of the lattice is left, the cubatic order how much of the directions; where a point has no error
bar the state still changes, and blocks cannot tell.
"""

import argparse
from pathlib import Path

import ase
import numpy as np

import analysis
import edmd
from analysis.colours import orientation_colours
from analysis.style import BLUE, ORANGE, POINTS, panels, picture_panel

SEMI_AXES = (1.0, 1.0, np.sqrt(3))
DENSEST = 0.7707
ROOM = 1e-8                     # relative: rows of bodies that touch exactly, tip to tip, have none to move in
PACKING_FRACTIONS = [0.74, 0.70, 0.66, 0.63, 0.60, 0.58, 0.56, 0.53, 0.50, 0.45]
RATE, FRAMES = 0.02, 64
K_MAX = 3.6                     # just beyond the reflections {111} of the lattice of centres
PIXELS = (700, 700)


def crystal(cells):
    """The crystal near its highest density, as ase.Atoms with shapes and orientations (x, y, z, w)."""
    edge, half = 2 * np.sqrt(3) * (1 + ROOM), np.sqrt(0.5)
    height = 4 * (4 * np.pi / 3 * np.prod(SEMI_AXES)) / (DENSEST * edge**2)
    sites = np.array([(0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5)]) + 0.25       # off the faces of the cell: a better picture
    atoms = ase.Atoms("X4", scaled_positions=sites, cell=(edge, edge, height), pbc=True)
    along_x, along_y = (0, half, 0, half), (-half, 0, 0, half)                  # quarter turns that bring the long axis there from z
    atoms.set_array("orientation", np.array([along_x, along_x, along_y, along_y]))
    atoms.set_array("aspherical_shape", np.tile(SEMI_AXES, (4, 1)))
    return atoms.repeat(cells)


def measured(simulation, collisions_per_particle):
    """Height of the Bragg peak, S / n, and cubatic order, with standard errors: ((peak, error), (order, error))."""
    waves, orders = [], []

    def see(view):
        system = view.system
        waves.append(analysis.structure_factor(system.positions, system.box, K_MAX)[1] / system.n)
        orders.append(analysis.cubatic_order(analysis.body_axes(system.orientations, system.semi_axes))[0])

    when = edmd.Every(collisions_per_particle=collisions_per_particle / FRAMES)
    simulation.run(collisions_per_particle=collisions_per_particle, observers=[edmd.Observer(when, see)])
    highest = np.argmax(np.mean(waves, axis=0))
    return [(np.mean(series), analysis.block_error(series)) for series in (np.array(waves)[:, highest], orders)]


def picture(system):
    """The bodies, coloured by orientation."""
    paint = orientation_colours(system.orientations, system.semi_axes)
    return analysis.image((system.positions, system.orientations, system.semi_axes), paint, system.box, PIXELS)


def draw(results, pictures, output):
    """`results` (packing fractions, 2, 2) as `measured` gives them; `pictures`: at the first and the last packing fraction."""
    figure, (left, middle, right) = panels(1, 3, (10.6, 3.6))
    for k, colour, label in ((0, BLUE, "Bragg peak $S(k)/n$"), (1, ORANGE, "cubatic order")):
        middle.errorbar(PACKING_FRACTIONS, results[:, k, 0], yerr=results[:, k, 1], color=colour, label=label, **POINTS | {"fmt": "o-"})
    middle.set(xlabel=r"packing fraction $\phi$", ylim=(0, 1.02))
    middle.set_title("(b)", loc="left", fontsize=10)
    middle.legend(frameon=False)
    for axes, pixels, letter, phi in ((left, pictures[0], "a", PACKING_FRACTIONS[0]), (right, pictures[1], "c", PACKING_FRACTIONS[-1])):
        picture_panel(axes, pixels)
        axes.set_title(f"({letter})  $\\phi = {phi:.2f}$", loc="left", fontsize=10)
    figure.savefig(output, dpi=200)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=4, help="unit cells a side: 4 cells^3 bodies")
    parser.add_argument("--collisions", type=float, default=500, help="per particle, to equilibrium and again to measure, at each step")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("crystal_from_ase"), help="where the figure goes")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    system = edmd.from_ase(crystal((options.cells,) * 3))
    print(f"{system.n} spheroids from ASE, packing fraction {system.packing_fraction:.4f}")
    simulation, results, pictures = edmd.Simulation(edmd.thermalized(system, options.seed)), [], []
    print("packing fraction     Bragg peak S/n       cubatic order")
    for phi in PACKING_FRACTIONS:
        simulation.compress(-RATE, until_packing_fraction=phi)
        simulation.run(collisions_per_particle=options.collisions)
        results.append(measured(simulation, options.collisions))
        if phi in (PACKING_FRACTIONS[0], PACKING_FRACTIONS[-1]):
            pictures.append(picture(simulation.system))
        (peak, peak_error), (order, order_error) = results[-1]
        print(f"{phi:16.2f}   {peak:.4f} +- {peak_error:.4f}   {order:.3f} +- {order_error:.3f}", flush=True)
    figure = options.folder / "crystal_from_ase.png"
    draw(np.array(results), pictures, figure)
    print(f"\nfigure  {figure}")


if __name__ == "__main__":
    main()
