"""How dense does a packing become, the slower it is compressed? A sweep of growth rates for spheres and for ellipsoids, on all cores.

Run it again and it only draws: every run that is done is kept. With --replicas 8 it adds what is missing.
"""

import argparse
from pathlib import Path

import numpy as np

import edmd
from analysis.style import BLUE, ORANGE, POINTS, panels

RATES = [0.3, 0.1, 0.03, 0.015]
SHAPES = {"spheres": [1.0, 1.0, 1.0], "ellipsoids 1.25 : 1 : 0.8": [1.25, 1.0, 0.8]}
PACKING = {
    "system": {"kind": "crystal", "n": 64},
    "stage": [{"kind": "run", "collisions_per_particle": 50},           # the crystal melts
              {"kind": "compress", "until_pressure": 1e5}],             # the rate is swept
}


def draw(table, output):
    """Mean packing fractions with standard errors over the replicas."""
    figure, axes = panels()
    for (name, shape), colour in zip(SHAPES.items(), (BLUE, ORANGE)):
        phi = [table["packing_fraction"][(table["stage.1.rate"] == rate) & (table["system.semi_axes.0"] == shape[0])] for rate in RATES]
        mean, error = [each.mean() for each in phi], [each.std(ddof=1) / np.sqrt(len(each)) for each in phi]
        axes.errorbar(RATES, mean, yerr=error, color=colour, label=name, **POINTS | {"fmt": "o-"})
        for rate, value, bar in zip(RATES, mean, error):
            print(f"{name:26} rate {rate:<5g} packing fraction {value:.4f} +- {bar:.4f}")
    axes.set(xscale="log", xlabel=r"growth rate of the semi-axes, $kT = m = 1$", ylabel=r"packing fraction $\phi$ at $PV/nkT = 10^5$")
    axes.set_xticks(RATES, [f"{rate:g}" for rate in RATES])
    axes.set_xticks([], minor=True)
    axes.legend(frameon=False)
    figure.savefig(output, dpi=200)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--replicas", type=int, default=3, help="runs of every rate and shape")
    parser.add_argument("--scheduler", default=None, help="address of a Dask scheduler (default: this machine)")
    parser.add_argument("--folder", type=Path, default=Path("compression_rates"), help="where the files go")
    options = parser.parse_args()
    table = edmd.sweep(PACKING, {"stage.1.rate": RATES, "system.semi_axes": list(SHAPES.values())}, options.folder / "sweep",
                       options.scheduler, replicas=options.replicas, progress=True,
                       plot={"x": "stage.1.rate", "y": ["packing_fraction", "contact_number"]})
    figure = options.folder / "compression_rates.png"
    draw(table, figure)
    print(f"\nfigure  {figure}\ntable   {options.folder / 'sweep' / 'table.csv'}")


if __name__ == "__main__":
    main()
