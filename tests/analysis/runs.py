"""Files after docs/file_format.md, written here with plain h5py: what edmd writes is not used to test what reads it."""

import json

import h5py
import numpy as np

UNITS = {"position": "Angstrom", "velocity": "Angstrom ps-1"}


def write_run(path, positions, orientations, semi_axes, cells, times, log=None, species=None, parameters=None,
              images=0, velocities=None):
    """One frame for each time; arrays lack the frame axis where they stand still."""
    frames, n = len(times), np.shape(positions)[-2]
    rng = np.random.default_rng(7)

    def every_frame(values, shape):
        return np.broadcast_to(np.asarray(values, dtype=float), (frames, *shape))

    series = {
        "position": every_frame(positions, (n, 3)),
        "velocity": rng.normal(size=(frames, n, 3)) if velocities is None else every_frame(velocities, (n, 3)),
        "orientation": every_frame(orientations, (n, 4)),
        "angular_velocity": rng.normal(size=(frames, n, 3)),
        "semi_axes": every_frame(semi_axes, (n, 3)),
        "image": every_frame(images, (n, 3)).astype(np.int32),
    }
    with h5py.File(path, "w") as file:
        file.create_group("h5md").attrs["version"] = [1, 1]
        file.create_group("h5md/author").attrs["name"] = "test"
        file.create_group("h5md/creator").attrs.update(name="edmd", version="0")
        particles = file.create_group("particles/trajectory")
        position = particles.create_group("position")
        position["step"] = np.arange(frames, dtype=np.int64) * 1000
        position["time"] = np.asarray(times, dtype=float)
        position["time"].attrs["unit"] = "ps"
        for name, values in series.items():
            group = linked(particles, name, position)
            group.create_dataset("value", data=values, chunks=(1, *values.shape[1:]))
            if name in UNITS:
                group["value"].attrs["unit"] = UNITS[name]
        box = particles.create_group("box")
        box.attrs.update(dimension=3, boundary=["periodic"] * 3)
        linked(box, "edges", position)["value"] = every_frame(cells, (3, 3))
        box["edges/value"].attrs["unit"] = "Angstrom"
        particles["species"] = np.zeros(n, dtype=np.int32) if species is None else np.asarray(species, dtype=np.int32)
        particles["id"] = np.arange(n, dtype=np.int32)
        particles["mass"] = 1.0 + particles["species"][()]
        observables = file.create_group("observables")
        for name in ("position", "orientation", "angular_velocity", "semi_axes", "image"):
            observables[name] = particles[name]
        linked(observables, "reduced_pressure", position)["value"] = np.array([np.nan] + [5.0] * (frames - 1))
        edmd = file.create_group("edmd")
        edmd.attrs.update(format=1, version="0", parameters=json.dumps(parameters or {"seed": 1}), seed=1, complete=True)
        for name, values in (log or {}).items():
            edmd[f"log/{name}"] = values
    return path


def wrapped(unwrapped, cell):
    """Positions inside the cell (3, 3), and the images that lead back to the unwrapped ones."""
    images = np.floor(unwrapped @ np.linalg.inv(cell))
    return unwrapped - images @ cell, images


def linked(parent, name, position):
    """A group whose step and time are those of the position."""
    group = parent.require_group(name)
    if "step" not in group:
        group["step"], group["time"] = position["step"], position["time"]
    return group


def random_quaternions(rng, n):
    q = rng.normal(size=(n, 4))
    return q / np.linalg.norm(q, axis=1)[:, None]


def fcc(cells):
    """Touching spheres of radius 1/2 in the cubic cell: positions (4 cells^3, 3) and cell."""
    basis = np.array([[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]])
    corners = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    return np.sqrt(2) * (corners + basis + 0.25).reshape(-1, 3), np.sqrt(2) * cells * np.eye(3)
