"""A gas of inelastic ellipsoids cools: Haff's law, T = T0 / (1 + t / tau)^2, and how rotation and translation share what is left."""

import argparse
from pathlib import Path

import numpy as np

import edmd
from analysis.style import BLUE, ORANGE, letter_panels, panels
from edmd.inertia import degrees_of_freedom, kinetic_energies

CONTACT_SHARE = 3e-3        # of the time in which a body moves by its length: collisions that follow sooner are elastic


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", type=int, default=1000, help="number of bodies")
    parser.add_argument("--semi-axes", type=float, nargs=3, default=[1.0, 1.0, 2.0], metavar=("A", "B", "C"))
    parser.add_argument("--packing-fraction", type=float, default=0.05)
    parser.add_argument("--restitution", type=float, default=0.9)
    parser.add_argument("--until", type=float, default=150.0, help="collisions per particle")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("cooling"), help="where the files go")
    options = parser.parse_args()
    options.folder.mkdir(exist_ok=True)

    print(f"{options.n} ellipsoids {options.semi_axes} cool at e = {options.restitution} ...", flush=True)
    start = edmd.random_system(options.n, options.semi_axes, options.packing_fraction, options.seed)
    start = edmd.thermalized(start, options.seed, spin="none")
    tau = haff_time(start, options.restitution)
    simulation = edmd.Simulation(start, rule=edmd.Inelastic(options.restitution, contact_share=CONTACT_SHARE))
    rows = []
    look = edmd.Observer(edmd.Logarithmic(collisions_per_particle=0.5, per_decade=20), lambda view: rows.append(shares(view)))
    with edmd.Trajectory(options.folder / "cooling.h5md", edmd.Every(collisions_per_particle=10), overwrite=True) as trajectory:
        simulation.run(collisions_per_particle=options.until, observers=[trajectory, look])
    simulation.verify()
    times, temperature, translation, rotation = np.transpose(rows)
    figure = options.folder / "cooling.png"
    draw(figure, tau, times, temperature, rotation / translation if rotation.any() else None)
    past = simulation.time / tau
    print(f"""
Haff's time tau           {tau:.4g}
temperature               {simulation.temperature:.4g} at t = {past:.3g} tau; Haff's law says {(1 + past)**-2:.4g}
made elastic by TC        {simulation.contact_time_collisions} of {simulation.collisions} collisions
figure, trajectory        {figure}, {trajectory.path}""")


def haff_time(start, restitution):
    """tau = 2 f / ((1 - e^2) Gamma), f degrees of freedom a body and Gamma the collision rate of the elastic gas, which is measured."""
    elastic = edmd.Simulation(start).run(collisions_per_particle=20)
    return 2 * degrees_of_freedom(start) / start.n / ((1 - restitution**2) * elastic.collision_rate)


def shares(view):
    """Time, temperature, and those of translation and rotation alone, with the degrees of freedom of each."""
    translation, rotation = kinetic_energies(view.system)
    moving = 3 * view.n - 3
    return view.time, view.temperature, 2 * translation / moving, 2 * rotation / max(degrees_of_freedom(view.system) - moving, 1)


def draw(path, tau, times, temperature, ratio):
    figure, (law, share) = panels(1, 2, (8.4, 3.5))
    curve = np.geomspace(times[0], times[-1], 200) / tau
    law.loglog(curve, (1 + curve)**-2, color=ORANGE, label="Haff's law, $(1 + t/\\tau)^{-2}$")
    law.loglog(times / tau, temperature, "o", markersize=3.5, color=BLUE, label="events")
    law.set(xlabel="$t / \\tau$", ylabel="$T / T_0$")
    law.legend(frameon=False)
    if ratio is not None:
        share.semilogx(times / tau, ratio, "o", markersize=3.5, color=BLUE)
        share.axhline(1, color=ORANGE, linewidth=1.2)
        share.set(xlabel="$t / \\tau$", ylabel="$T_{\\mathrm{rotation}}\\, /\\, T_{\\mathrm{translation}}$", ylim=(0.8, 1.2))
    letter_panels(figure)
    figure.savefig(path, dpi=200)


if __name__ == "__main__":
    main()
