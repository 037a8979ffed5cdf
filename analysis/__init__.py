"""Runs as MDAnalysis sees them. `import analysis` registers the file format: `MDAnalysis.Universe("run.h5md")` then has
everything in it.

Each observable is a plain function of arrays, and an `AnalysisBase` that applies it along a trajectory (docs/analysis.md). What
draws loads when it is first used.
"""

import importlib
from typing import TYPE_CHECKING

from analysis.axes import body_axes, three_axes
from analysis.blocks import block_error, weighted_mean
from analysis.bond_order import SteinhardtOrder, steinhardt_order
from analysis.contacts import ContactNumbers, NearContacts, gaps
from analysis.dynamics import (
    MeanSquaredDisplacement,
    OrientationalCorrelation,
    mean_squared_displacement,
    orientational_correlation,
    time_lags,
)
from analysis.free_volume import FreeVolumes, free_volumes, jamming_point
from analysis.order import BiaxialOrder, CubaticOrder, NematicOrder, biaxial_order, cubatic_order, nematic_order, nematic_tensor
from analysis.pressure import mean_pressure
from analysis.radial import (
    CylindricalDistribution,
    OrientationalPairCorrelation,
    RadialDistribution,
    across,
    along,
    cylindrical_distribution,
    orientational_pair_correlation,
    radial_distribution,
)
from analysis.reader import EDMDParser, EDMDReader, unwrap
from analysis.scattering import StructureFactor, structure_factor
from analysis.summary import summarize
from ccd.contacts import contact_numbers, contact_pairs, rattlers

if TYPE_CHECKING:
    from analysis.curves import plot_compression, plot_curve, read_log
    from analysis.picture import image, render, render_series
    from analysis.style import panels

_DRAWING = {"image": "picture", "plot_compression": "curves", "plot_curve": "curves", "read_log": "curves", "render": "picture",
            "render_series": "picture", "panels": "style"}

__all__ = [
    "BiaxialOrder", "ContactNumbers", "CubaticOrder", "CylindricalDistribution", "EDMDParser", "EDMDReader", "FreeVolumes",
    "MeanSquaredDisplacement", "NearContacts", "NematicOrder", "OrientationalCorrelation", "OrientationalPairCorrelation",
    "RadialDistribution", "SteinhardtOrder", "StructureFactor", "across", "along", "biaxial_order", "block_error", "body_axes",
    "contact_numbers", "contact_pairs", "cubatic_order", "cylindrical_distribution", "free_volumes", "gaps", "image", "jamming_point",
    "mean_pressure", "mean_squared_displacement", "nematic_order", "nematic_tensor", "orientational_correlation",
    "orientational_pair_correlation", "panels", "plot_compression", "plot_curve", "radial_distribution", "rattlers", "read_log", "render",
    "render_series", "steinhardt_order", "structure_factor", "summarize", "three_axes", "time_lags", "unwrap", "weighted_mean",
]


def __getattr__(name):
    if name in _DRAWING:
        return getattr(importlib.import_module(f"analysis.{_DRAWING[name]}"), name)
    raise AttributeError(f"module 'analysis' has no attribute {name!r}")
