"""Runs as MDAnalysis sees them. `import analysis` registers the file format: `MDAnalysis.Universe("run.h5md")` then has
everything in it.

Each observable is a plain function of arrays, and an `AnalysisBase` that applies it along a trajectory. What draws loads
when it is first used.
"""

import importlib

from analysis.axes import body_axes, three_axes
from analysis.blocks import block_error
from analysis.contacts import ContactNumbers, NearContacts, gaps
from analysis.order import BiaxialOrder, CubaticOrder, NematicOrder, biaxial_order, cubatic_order, nematic_order, nematic_tensor
from analysis.radial import RadialDistribution, radial_distribution
from analysis.reader import EDMDParser, EDMDReader, unwrap
from analysis.summary import summarize
from ccd.contacts import contact_numbers, contact_pairs, rattlers

_DRAWING = {"image": "picture", "plot_compression": "curves", "read_log": "curves", "render": "picture"}

__all__ = [
    "ContactNumbers", "EDMDParser", "EDMDReader", "NematicOrder", "RadialDistribution", "body_axes", "contact_numbers",
    "contact_pairs", "image", "nematic_order", "nematic_tensor", "plot_compression", "radial_distribution", "rattlers",
    "read_log", "render", "summarize", "unwrap",
]


def __getattr__(name):
    if name in _DRAWING:
        return getattr(importlib.import_module(f"analysis.{_DRAWING[name]}"), name)
    raise AttributeError(f"module 'analysis' has no attribute {name!r}")
