"""Scripts as users write them, for the type checker: what it says of the public names has to fit how they are called. Not run."""

import MDAnalysis as mda
import numpy as np

import analysis
import ccd
import edmd


def two_bodies() -> float:
    a, b = ccd.Ellipsoid((1, 2, 0.5)), ccd.Ellipsoid([1, 1, 3], center=np.array([6.0, 1.0, 0.0]))
    contact = ccd.first_contact(a, ccd.FreeFlight((1, 0, 0), angular_velocity=(0, 0, 1)), b, ccd.Rest(), t_span=(0, 10))
    for interval in ccd.contact_intervals(a, ccd.Rest(), b, ccd.interpolate_rigid(b, a)):
        print(interval.state.name, interval.start + interval.end, interval.end_point[0])
    bodies = ccd.Bodies((1, 1, 2), np.zeros((3, 3)), [[1, 0, 0, 0]] * 3, growth_rate=0.1)
    times, statuses = ccd.batch.first_contact(bodies, bodies, t_max=2.0)
    return contact.time + ccd.separation(a, b).gap + float(times[statuses == ccd.Status.CONTACT].min()) + float(bodies.center[0, 0])


def a_run() -> np.ndarray:
    system = edmd.lattice("fcc", (1, 1, 2), 0.4, cells=(5, 5, 5), seed=1)
    simulation = edmd.Simulation(system, restitution=0.9)
    with edmd.Trajectory("run.h5md", when=edmd.Every(time=0.5)) as trajectory:
        simulation.run(time=10, observers=[trajectory, edmd.Observer(edmd.Every(collisions=100), lambda view: print(view.energy))])
    edmd.export("run.h5md", "run.xyz", frames=slice(0, None, 5))
    packing = edmd.pack(64, [1, 1, 1.5], rate=1e-2)
    table = edmd.sweep({"system": {"n": 16}}, {"stage.0.rate": [0.1, 0.2]}, "rates")
    simulation.compress({0: 0.1, 100: 1e-2}, until_pressure=1e3).rescale(2).thermalize(seed=3)
    return packing.system.positions * simulation.compress(0.1, until_packing_fraction=0.5).packing_fraction + table["seed"][0]


def an_analysis() -> float:
    universe = mda.Universe("run.h5md")
    near = analysis.NearContacts(universe.atoms, smallest=1e-7).run(start=-1).results
    r, g = analysis.radial_distribution(np.zeros((4, 3)), 5 * np.eye(3), 2.0)
    analysis.plot_curve(r, g, "g.png", x_label="r")
    pressure, error = analysis.mean_pressure("run.h5md")["reduced_pressure"]
    order, director = analysis.nematic_order([[0, 0, 1]])
    return pressure + error + order + float(director[0]) + float(near.contacts[-1])
