"""The periodic triclinic cell: images of bodies and pairs. Rows of the box are the cell vectors, lower triangular."""

from math import floor

from ccd.compiling import kernel


@kernel
def displaced(r, box, a, b, c):
    """r moved by a, b, c cell vectors."""
    return (r[0] + a * box[0, 0] + b * box[1, 0] + c * box[2, 0],
            r[1] + a * box[0, 1] + b * box[1, 1] + c * box[2, 1],
            r[2] + a * box[0, 2] + b * box[1, 2] + c * box[2, 2])


@kernel
def fraction(x, inverse):
    """Coordinates in units of the cell vectors."""
    return displaced((0.0, 0.0, 0.0), inverse, x[0], x[1], x[2])


@kernel
def image_of(x, inverse):
    """How many cell vectors x lies outside the home cell: three integers."""
    f = fraction(x, inverse)
    return int(floor(f[0])), int(floor(f[1])), int(floor(f[2]))
