"""How do curves look? One style for all figures: those of `edmd plot`, of the examples, and a user's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ccd.annotations import Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE, ORANGE, GREEN = COLOURS = ("#1f4e8c", "#c8551e", "#3a7d44")
POINTS = {"fmt": "o", "markersize": 4, "capsize": 2.5, "elinewidth": 0.9, "linewidth": 1.2}        # of Axes.errorbar


def panels(rows: int = 1, columns: int = 1, size: tuple[float, float] = (4.8, 3.6), **layout: Any) -> tuple[Figure, Any]:
    """A figure for a paper and its axes, a matplotlib Figure and what its `subplots(rows, columns, **layout)` gives.

    `size` in inches. It needs no display and no pyplot: draw, then `figure.savefig("name.pdf")`.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    made = figure.subplots(rows, columns, **layout)
    for axes in figure.axes:
        axes.grid(True, color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    return figure, made


def picture_panel(axes, pixels, title=None):
    """Show a picture (height, width, 3), as `analysis.image` gives it, in a panel: no axes, no grid."""
    axes.imshow(pixels)
    axes.axis("off")
    if title:
        axes.set_title(title, fontsize=10)


def letter_panels(figure):
    """(a), (b), ... in the upper left corner of each panel, as journals ask."""
    for axes, letter in zip(figure.axes, "abcdefgh", strict=False):
        axes.set_title(f"({letter})", loc="left", fontsize=10)


def plain_ticks(axes):
    """1, 2, 5, ... in plain numbers on logarithmic axes of less than two decades, where powers of ten are too few or too wide."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    for axis, scale, (low, high) in ((axes.xaxis, axes.get_xscale(), axes.get_xlim()), (axes.yaxis, axes.get_yscale(), axes.get_ylim())):
        if scale == "log" and high < 100 * low:
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())
