"""LAMMPS text dumps (`dump custom`), with the shape and orientation columns that OVITO maps to ellipsoids."""

import numpy as np

from edmd.formats.text import TILTS, frame_index, table
from edmd.system import System

GROUPS = {"position": "x y z", "image": "ix iy iz", "velocity": "vx vy vz", "angular velocity": "omegax omegay omegaz",
          "orientation": "quatw quati quatj quatk", "shape": "shapex shapey shapez"}
COLUMNS = "id type mass " + " ".join(GROUPS.values())
START = b"ITEM: TIMESTEP"
ITEMS = ("TIMESTEP", "NUMBER OF ATOMS", "BOX BOUNDS", "ATOMS")


def write(path, frames):
    with open(path, "w", encoding="utf-8") as file:
        for system, images, _, step in frames:
            box = system.box
            tilts = box[TILTS]
            extra = _overhang(*tilts)
            bounds = np.column_stack([extra[:, 0], np.diag(box) + extra[:, 1]])
            skew = tilts.any()
            file.write(f"ITEM: TIMESTEP\n{int(step)}\nITEM: NUMBER OF ATOMS\n{system.n}\n"
                       f"ITEM: BOX BOUNDS {'xy xz yz ' if skew else ''}pp pp pp\n"
                       f"{table(bounds, tilts) if skew else table(bounds)}ITEM: ATOMS {COLUMNS}\n")
            file.write(table(np.arange(1, system.n + 1), system.species + 1, system.masses, system.positions, images, system.velocities,
                             system.angular_velocities, system.orientations, 2 * system.semi_axes))


def read(path, frame=-1, inertia=None):
    step, box, columns = _frame(path, frame)
    absent = [name for name in f"type {GROUPS['position']} {GROUPS['orientation']} {GROUPS['shape']}".split() if name not in columns]
    if absent:
        raise ValueError(f"path = {str(path)!r}: the frame of step {step} has no columns {' '.join(absent)}; expected them as edmd writes "
                         "them, or from compute property/atom with dump_modify colname")
    order = np.argsort(columns["id"].astype(int), kind="stable") if "id" in columns else slice(None)

    def group(names):
        known = [columns[name].astype(float) for name in names.split() if name in columns]
        return np.column_stack(known)[order] if len(known) == len(names.split()) else None

    edges, origin = box
    masses = 1.0 if "mass" not in columns else group("mass")[:, 0]
    return System(group(GROUPS["position"]) - origin, group(GROUPS["orientation"]), group(GROUPS["shape"]) / 2, edges,
                  group(GROUPS["velocity"]), group(GROUPS["angular velocity"]), masses, "solid" if inertia is None else inertia,
                  columns["type"][order].astype(int) - 1)


def _frame(path, frame):
    """-> step, (cell vectors, origin), {column: words} of one frame; only that frame is parsed."""
    starts, at = [], 0
    try:
        with open(path, "rb") as file:
            for line in file:
                if line.startswith(START):
                    starts.append(at)
                at += len(line)
            frame = frame_index(frame, len(starts), path)
            file.seek(starts[frame])
            text = file.read((starts + [at])[frame + 1] - starts[frame]).decode()
    except (OSError, UnicodeDecodeError) as problem:
        raise ValueError(f"path = {str(path)!r}: cannot be read as text ({problem})") from None
    items = {}
    for item in text.split("ITEM: ")[1:]:
        title, _, rows = item.partition("\n")
        items[next((known for known in ITEMS if title.startswith(known)), title)] = title, rows
    try:
        step, count = int(items["TIMESTEP"][1]), int(items["NUMBER OF ATOMS"][1])
        bounds = np.array(items["BOX BOUNDS"][1].split(), dtype=float).reshape(3, -1)
        names = items["ATOMS"][0].split()[1:]
        words = np.array([row.split() for row in items["ATOMS"][1].splitlines()])
        if bounds.shape[1] not in (2, 3) or words.shape != (count, len(names)):
            raise ValueError(f"{len(words)} lines for {count} atoms of {len(names)} columns, {bounds.shape[1]} numbers a bound")
    except (KeyError, IndexError, ValueError) as problem:
        raise ValueError(f"path = {str(path)!r}: frame {frame} is not one of a LAMMPS text dump, or is truncated ({problem})") from None
    tilts = bounds[:, 2] if bounds.shape[1] == 3 else np.zeros(3)
    bounds = bounds[:, :2] - _overhang(*tilts)
    edges = np.diag(bounds[:, 1] - bounds[:, 0])
    edges[TILTS] = tilts
    return step, (edges, bounds[:, 0]), dict(zip(names, words.T))


def _overhang(xy, xz, yz):
    """How far the box that bounds a skew cell reaches beyond its edges, (3, 2): below 0, above the length."""
    x, y = (0, xy, xz, xy + xz), (0, yz)
    return np.array([[min(x), max(x)], [min(y), max(y)], [0, 0]])
