"""Which colour does a body get? Perceptually even ones, by OKLab (Ottosson 2020): equal steps look equal.

All functions return linear RGB (n, 3).
"""

import numpy as np

from analysis.axes import body_axes

SPECIES = np.array([[0.68, -0.05, -0.10], [0.74, 0.07, 0.10], [0.72, -0.10, 0.07], [0.66, 0.13, -0.02], [0.80, -0.01, 0.14],
                    [0.60, 0.05, -0.13]])
RATTLER = np.array([0.90, 0.0, 0.0])
CONTACTS = (4, 8, 12)
FEW_TO_MANY = np.array([[0.90, -0.02, 0.12], [0.70, -0.10, -0.01], [0.42, 0.00, -0.14]])


def orientation_colours(orientations, semi_axes):
    """A colour for the body's axis, the same for u and -u and smooth everywhere.

    Hue turns twice while the axis turns once about z, so that perpendicular axes in the xy plane have opposite hues; along
    z all colour fades into a light grey. An axis and its mirror image in the xy plane look the same. Spheres, whose axis
    cannot be seen, share one blue.
    """
    x, y, z = body_axes(orientations, semi_axes).T
    lab = np.column_stack([0.73 + 0.13 * z * z, 0.125 * (x * x - y * y), 0.125 * 2 * x * y])
    sphere = np.isclose(np.ptp(semi_axes, axis=1), 0.0, atol=1e-9 * np.max(semi_axes))
    return linear_rgb(np.where(sphere[:, None], SPECIES[0], lab))


def species_colours(species):
    """One colour for each species number (n,); after six they repeat."""
    return linear_rgb(SPECIES[np.asarray(species, dtype=int) % len(SPECIES)])


def contact_colours(contact_numbers, rattlers):
    """From pale yellow (4 contacts) over green (8) to deep blue (12 and more); rattlers, a mask (n,), are white."""
    lab = np.column_stack([np.interp(contact_numbers, CONTACTS, channel) for channel in FEW_TO_MANY.T])
    return linear_rgb(np.where(np.asarray(rattlers)[:, None], RATTLER, lab))


def linear_rgb(oklab):
    """Linear sRGB (n, 3), cut to [0, 1], of OKLab colours (n, 3): lightness, green to red, blue to yellow."""
    to_cones = np.array([[1, 0.3963377774, 0.2158037573], [1, -0.1055613458, -0.0638541728], [1, -0.0894841775, -1.2914855480]])
    to_rgb = np.array([[4.0767416621, -3.3077115913, 0.2309699292], [-1.2684380046, 2.6097574011, -0.3413193965],
                       [-0.0041960863, -0.7034186147, 1.7076147010]])
    return np.clip((oklab @ to_cones.T) ** 3 @ to_rgb.T, 0.0, 1.0)


def encoded(linear):
    """sRGB bytes of linear light in [0, 1]."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.round(255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)).astype(np.uint8)
