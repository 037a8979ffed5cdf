"""GSD, the file of HOOMD: an Ellipsoid in `type_shapes` for every shape, float32 as HOOMD has it."""

import re

import numpy as np

from ccd.quaternions import products, to_body, to_lab
from edmd.formats.text import TILTS, frame_index
from edmd.system import System

CONJUGATE = np.array([1, -1, -1, -1])


def write(path, frames):
    gsd = _library()
    with gsd.open(str(path), "w") as file:
        for frame in frames:
            file.append(_snapshot(gsd, *frame))


def read(path, frame=-1, inertia=None):
    gsd = _library()
    try:
        file = gsd.open(str(path), "r")
    except (OSError, RuntimeError) as problem:
        raise ValueError(f"path = {str(path)!r}: not a GSD file ({problem})") from None
    with file:
        at = file[frame_index(frame, len(file), path)]
    bodies, sizes = at.particles, np.array(at.configuration.box, dtype=float)
    box = np.diag(sizes[:3])
    box[TILTS] = sizes[3:] * sizes[[1, 2, 2]]
    semi_axes = np.array([_semi_axes(shape, path) for shape in bodies.type_shapes] or [_semi_axes({}, path)])
    if len(semi_axes) < len(bodies.types):
        raise ValueError(f"path = {str(path)!r}: {len(semi_axes)} type_shapes for {len(bodies.types)} types; expected one for each")
    system = System(bodies.position + box.sum(axis=0) / 2, bodies.orientation, semi_axes[bodies.typeid], box, bodies.velocity,
                    masses=bodies.mass, species=_species(bodies.types)[bodies.typeid])
    moments = np.array(bodies.moment_inertia, dtype=float)
    known = (moments > 0).all()
    momenta = products(system.orientations * CONJUGATE, np.array(bodies.angmom, dtype=float))[:, 1:] / 2
    in_body = momenta / np.where(moments > 0, moments, np.inf)          # about an axis without inertia nothing turns in HOOMD
    return System(system.positions, system.orientations, system.semi_axes, box, system.velocities,
                  to_lab(system.orientations, in_body), system.masses,
                  inertia if inertia is not None else moments if known else "solid", system.species)


def _snapshot(gsd, system, images, time, step):
    """Positions count from the middle of the cell; angular momentum is the quaternion 2 q S, S in the body's frame."""
    box = system.box
    shapes, typeid = np.unique(np.column_stack([system.species, system.semi_axes]), axis=0, return_inverse=True)
    momenta = system.moments * to_body(system.orientations, system.angular_velocities)
    frame = gsd.Frame()
    frame.configuration.step = int(step)
    edges = np.diag(box)
    frame.configuration.box = _single([*edges, *(box[TILTS] / edges[[1, 2, 2]])])
    bodies = frame.particles
    bodies.N, bodies.typeid, bodies.types = system.n, np.ravel(typeid).astype(np.uint32), _type_names(shapes[:, 0].astype(int))
    bodies.type_shapes = [{"type": "Ellipsoid", "a": a, "b": b, "c": c} for _, a, b, c in shapes.tolist()]
    bodies.position, bodies.image = _single(system.positions - box.sum(axis=0) / 2), images
    bodies.orientation, bodies.mass = _single(system.orientations), _single(system.masses)
    bodies.velocity, bodies.moment_inertia = _single(system.velocities), _single(system.moments)
    bodies.angmom = _single(2 * products(system.orientations, np.column_stack([np.zeros(system.n), momenta])))
    bodies.diameter = _single(2 * np.cbrt(system.semi_axes.prod(axis=1)))
    frame.log["time"] = np.array([time], dtype=float)
    return frame


def _single(values):
    return np.asarray(values, dtype=np.float32)


def _type_names(species):
    """The species label; with a number behind it where a species has several shapes."""
    several = np.bincount(species)[species] > 1
    return [f"{k}.{i}" if many else f"{k}" for i, (k, many) in enumerate(zip(species.tolist(), several))]


def _species(types):
    """Labels out of type names as written here; the type's number for any others."""
    ours = [re.fullmatch(r"(\d+)(\.\d+)?", name) for name in types]
    return np.array([int(name[1]) for name in ours] if all(ours) else range(len(types)))


def _semi_axes(shape, path):
    if shape.get("type") == "Ellipsoid":
        return [shape["a"], shape["b"], shape["c"]]
    if shape.get("type") == "Sphere":
        return [shape["diameter"] / 2] * 3
    raise ValueError(f"path = {str(path)!r}: type_shapes has {shape!r}; expected an Ellipsoid or a Sphere for every type")


def _library():
    try:
        import gsd.hoomd
    except ImportError:
        raise ValueError("format = 'gsd': needs the package gsd; install it with pip install 'edmd[gsd]', or pip install gsd") from None
    return gsd.hoomd
