"""Extended XYZ, with the column names that OVITO maps to ellipsoids. Written here, because ASE's writer keeps 8 decimals; read by ASE."""

from collections import deque
from itertools import islice

from edmd.formats.text import frame_index, table, words
from edmd.initial import from_ase
from edmd.system import element_symbols

PROPERTIES = ("species:S:1:pos:R:3:orientation:R:4:aspherical_shape:R:3:velo:R:3:omega:R:3:mass:R:1:moments_of_inertia:R:3:tags:I:1:"
              "map_shift:I:3")


def write(path, frames):
    with open(path, "w", encoding="utf-8") as file:
        for system, images, time, step in frames:
            file.write(f"{system.n}\n"
                       f'Lattice="{words(system.box)}" Properties={PROPERTIES} pbc="T T T" time={float(time)!r} step={int(step)}\n')
            file.write(table(element_symbols(system.species), system.positions, system.orientations[:, [1, 2, 3, 0]], system.semi_axes,
                             system.velocities, system.angular_velocities, system.masses, system.moments, system.species, images))


def read(path, frame=-1, inertia=None):
    import ase.io

    try:
        index = frame_index(frame, _count(path), path)
        atoms = ase.io.read(path, index=index, format="extxyz")
    except (ValueError, KeyError, OSError) as problem:          # ASE's own XYZError is an OSError
        if str(problem).startswith(("frame", "path")):
            raise
        raise ValueError(f"path = {str(path)!r}: not extended XYZ that ASE can read ({problem})") from None
    return from_ase(atoms, inertia=inertia)


def _count(path):
    """The number of frames: ASE takes the first one for a frame that would lie before it."""
    frames = 0
    with open(path, encoding="utf-8") as file:
        while (line := file.readline()).strip():
            frames += 1
            deque(islice(file, int(line) + 1), maxlen=0)
    return frames
