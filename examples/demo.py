"""From a crystal to a jammed packing, its file, its analysis and its picture: what `make demo` runs."""

import argparse
from pathlib import Path

import MDAnalysis as mda

import analysis
import edmd
from edmd.progress import Progress

UNTIL_PRESSURE = 1e8
CONTACT_GAP = 1e-5


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", type=int, default=256, help="number of bodies")
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.25, 1.0, 0.8], metavar=("A", "B", "C"))
    parser.add_argument("--rate", type=float, default=1e-3, help="growth rate of the semi-axes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("demo"), help="where the files go")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)
    file, picture, plot = (options.folder / name for name in ("packing.h5md", "packing.png", "compression.png"))

    print(f"Packing {options.n} ellipsoids with semi-axes {options.semi_axes} (the first run compiles for a minute or two) ...", flush=True)
    progress = Progress(UNTIL_PRESSURE)
    packing = edmd.pack(options.n, options.semi_axes, options.rate, options.seed, until_pressure=UNTIL_PRESSURE, contact_gap=CONTACT_GAP,
                        output=file, overwrite=True, observers=[progress])
    progress.close()

    universe = mda.Universe(file)           # knows orientations and semi-axes, because analysis is imported
    last = [len(universe.trajectory) - 1]
    contacts = analysis.ContactNumbers(universe.atoms, gap=CONTACT_GAP).run(frames=last).results
    nematic = analysis.NematicOrder(universe.atoms).run(frames=last).results
    universe.trajectory.close()
    analysis.plot_compression(file, plot)
    analysis.render(file, picture)

    print(f"""
packing fraction     {packing.packing_fraction:.4f}
mean contact number  {contacts.mean[0]:.2f} (gaps below {CONTACT_GAP:g}), {contacts.rattlers[0]} rattlers
nematic order        {nematic.order[0]:.3f}
collisions           {packing.collisions:,}, {packing.collisions / packing.seconds:,.0f} per CPU second with compilation

trajectory           {file}   (opens in MDAnalysis: MDAnalysis.Universe("{file}"))
picture              {picture}
compression          {plot}

Next:  .venv/bin/edmd info {file}
       .venv/bin/edmd verify {file}
       .venv/bin/edmd pack -n 500 --semi-axes 1 1 2 --rate 1e-3 --seed 7 -o spheroids.h5md
       .venv/bin/edmd render spheroids.h5md --colour contacts""")


if __name__ == "__main__":
    main()
