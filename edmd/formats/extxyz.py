"""Extended XYZ, with the column names that OVITO maps to ellipsoids. Written here, because ASE's writer keeps 8 decimals; read by ASE."""

from edmd.formats.text import table, words
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
        atoms = ase.io.read(path, index=frame, format="extxyz")
    except (IndexError, StopIteration):
        raise ValueError(f"frame = {frame}: {str(path)!r} has no such frame") from None
    except (ValueError, KeyError, OSError) as problem:          # ASE's own XYZError is an OSError
        raise ValueError(f"path = {str(path)!r}: not extended XYZ that ASE can read ({problem})") from None
    return from_ase(atoms, inertia=inertia)
