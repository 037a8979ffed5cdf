"""Who touches whom in the last frame of a packing, and who is a rattler? The pairs as a table, their network as a figure."""

import argparse
import csv
from pathlib import Path

import MDAnalysis as mda
import numpy as np
from matplotlib.ticker import MaxNLocator
from scipy.spatial.transform import Rotation

import analysis
import ccd
import edmd
from analysis.colours import contact_colours, linear_rgb
from analysis.style import BLUE, ORANGE, panels, picture_panel

UNTIL_PRESSURE, GAP = 1e8, 1e-5
BOND_WIDTH, JOINT = 0.08, 0.25                                      # in radii of a sphere of equal volume
BOND, RATTLER = (0.58, -0.02, -0.07), (0.66, 0.13, 0.10)            # OKLab
VIEW, PIXELS = (0.42, -1.0, 0.36), (700, 700)


def touching(positions, orientations, semi_axes, cell, pairs):
    """ccd.Separation of each pair (m, 2), with the second body in its nearest image, and the vectors (m, 3) from centre to centre."""
    between = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    between -= np.round(between @ np.linalg.inv(cell)) @ cell
    return [ccd.separation(ccd.Ellipsoid(semi_axes[i], positions[i], orientations[i]),
                           ccd.Ellipsoid(semi_axes[j], positions[i] + vector, orientations[j]))
            for (i, j), vector in zip(pairs, between)], between


def write_table(path, pairs, separations):
    """A row a contact: both bodies, the gap between their surfaces, and where and along which normal they touch."""
    with open(path, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["first", "second", "gap", "x", "y", "z", "normal_x", "normal_y", "normal_z"])
        table.writerows([*pair, each.gap, *each.point, *each.normal] for pair, each in zip(pairs.tolist(), separations))


def network(positions, pairs, between, loose, size):
    """Bodies for `analysis.image` that draw the network: a ball for each body, a thin spheroid for each contact; and their paint."""
    length = np.linalg.norm(between, axis=1)
    turned = [np.roll(Rotation.align_vectors([vector], [[0, 0, 1]])[0].as_quat(), 1) for vector in between]
    thin = np.full(len(pairs), BOND_WIDTH * size)
    bodies = (np.concatenate([positions, positions[pairs[:, 0]] + between / 2]),
              np.concatenate([np.tile([1.0, 0, 0, 0], (len(positions), 1)), turned]),
              np.concatenate([np.full((len(positions), 3), JOINT * size), np.column_stack([thin, thin, length / 2])]))
    paint = np.array([RATTLER if each else BOND for each in loose] + [BOND] * len(pairs))
    return bodies, linear_rgb(paint)


def draw(bodies, cell, pairs, between, output):
    """The bodies coloured by their contacts, the network, and how many have how many."""
    n = len(bodies[0])
    numbers, loose = analysis.contact_numbers(pairs, n), analysis.rattlers(pairs, n)
    figure, (left, middle, right) = panels(1, 3, (10.6, 3.6))
    net, paint = network(bodies[0], pairs, between, loose, np.cbrt(bodies[2].prod(axis=1).mean()))
    picture_panel(left, analysis.image(bodies, contact_colours(numbers, loose), cell, PIXELS, VIEW))
    picture_panel(middle, analysis.image(net, paint, cell, PIXELS, VIEW))
    edges = np.arange(numbers.max() + 2) - 0.5
    right.hist([numbers[~loose], numbers[loose]], bins=edges, stacked=True, color=[BLUE, ORANGE],
               label=["held", f"rattlers ({loose.sum()} of {n})"])
    right.set(xlabel="contacts of a body", ylabel="bodies")
    right.xaxis.set_major_locator(MaxNLocator(integer=True))
    right.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.55, 1.0), ncols=2)
    for axes, letter in zip((left, middle, right), "abc"):
        axes.set_title(f"({letter})", loc="left", fontsize=10)
    figure.savefig(output, dpi=200)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", type=int, default=150, help="bodies")
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 1.02], metavar=("A", "B", "C"))
    parser.add_argument("--rate", type=float, default=3e-3, help="growth rate of the semi-axes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("contacts_of_a_frame"), help="where the files go")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    file, table, figure = (options.folder / name for name in ("packing.h5md", "contacts.csv", "contacts.png"))
    edmd.pack(options.n, options.semi_axes, options.rate, options.seed, UNTIL_PRESSURE, output=file, overwrite=True)

    universe = mda.Universe(file)
    last = universe.trajectory[-1].data                                         # float64; MDAnalysis' own positions are float32
    bodies, cell = tuple(last[name].copy() for name in ("position", "orientation", "semi_axes")), last["cell"].copy()
    universe.trajectory.close()
    pairs = analysis.contact_pairs(*bodies, cell, GAP)
    separations, between = touching(*bodies, cell, pairs)
    write_table(table, pairs, separations)
    draw(bodies, cell, pairs, between, figure)
    print(f"{len(pairs)} contacts between {options.n} bodies, surfaces at most {max(each.gap for each in separations):.1e} apart;"
          f" rattlers: {', '.join(map(str, np.flatnonzero(analysis.rattlers(pairs, options.n)))) or 'none'}")
    print(f"\nfigure  {figure}\ntable   {table}")


if __name__ == "__main__":
    main()
