"""The summary plot of a sweep: results against a parameter, with error bars over replicas."""

import io
from pathlib import Path
from typing import NamedTuple

import numpy as np

from edmd.config import nearest
from edmd.sweeps.results import write_whole

FIGURE = "summary.png"
PANELS, LEGEND = 4, 8           # at most: results drawn when none are named, series told apart by a legend
SAME = 1e-9                     # relative: a result that varies less is constant
WIDE = 20                       # ratio of the largest to the smallest value from which on an axis is logarithmic
BAR = {"elinewidth": 0.9, "capsize": 2.5, "markersize": 4, "linewidth": 1.3}


class Series(NamedTuple):
    """One curve: what its points share, and mean and standard error over the replicas at each x (nan: a single replica)."""

    label: str
    x: np.ndarray
    mean: np.ndarray
    error: np.ndarray


def draw_summary(directory, columns, parameters, x=None, y=None):
    """Draw results y (names; default: the first that vary) against the parameter x (default: the first that varies). -> the paths
    written: none when no result varies."""
    check_names(columns, x, y)
    varied = [name for name in parameters if len(set(columns[name].tolist())) > 1]
    numeric = [name for name in varied if _is_numeric(columns[name])]
    x = x or (numeric or ["replica"])[0]
    y = y or _results(columns, parameters)[:PANELS]
    if not y:
        return []
    from matplotlib.figure import Figure

    others = [name for name in varied if name != x and not _follows(columns, name, x)]
    across = min(len(y), 2)
    figure = Figure(figsize=(5.2 * across, 3.9 * -(-len(y) // across)), layout="constrained")
    panels = figure.subplots(-(-len(y) // across), across, squeeze=False).ravel()
    for axes, name in zip(panels, y):
        _panel(axes, columns, x, name, others)
    for axes in panels[len(y):]:
        axes.remove()
    picture = io.BytesIO()
    figure.savefig(picture, dpi=150, format="png")
    write_whole(Path(directory) / FIGURE, picture.getvalue())
    return [Path(directory) / FIGURE]


def check_names(columns, x, y):
    """ValueError when there is no such column of numbers."""
    for name, part in ((x, "plot.x"), *((one, "plot.y") for one in y or ())):
        if name is not None and (name not in columns or not _is_numeric(columns[name])):
            numeric = [one for one in columns if _is_numeric(columns[one])]
            raise ValueError(f"{part} = {name!r}: no such column of numbers{nearest(name, numeric)}; expected one of {', '.join(numeric)}")


def series_of(columns, x, y, others):
    """The curves of y against x: one for every combination of the other parameters."""
    groups = {}
    for i in np.flatnonzero(np.isfinite(columns[x].astype(float)) & np.isfinite(columns[y].astype(float))):
        key = tuple(columns[name][i] for name in others)
        groups.setdefault(key, {}).setdefault(float(columns[x][i]), []).append(float(columns[y][i]))
    made = []
    for key, points in sorted(groups.items(), key=lambda item: _sortable(item[0])):
        at = sorted(points)
        made.append(Series(", ".join(f"{_short(name)} {value:g}" if isinstance(value, float | np.floating) else f"{_short(name)} {value}"
                                     for name, value in zip(others, key)), np.array(at), np.array([np.mean(points[one]) for one in at]),
                           np.array([_error(points[one]) for one in at])))
    return made


def _panel(axes, columns, x, y, others):
    series = series_of(columns, x, y, others)
    scattered = len(series) > LEGEND
    for number, one in enumerate(series):
        colour = _colour(number, len(series))
        lone = scattered and len(one.x) == 1
        axes.errorbar(one.x, one.mean, yerr=np.nan_to_num(one.error), fmt="o" if lone else "o-", color=colour, label=one.label, **BAR)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    for scale, values in ((axes.set_xscale, columns[x]), (axes.set_yscale, columns[y])):
        if _is_wide(values):
            scale("log")
    axes.grid(True, color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    if others and not scattered and series:
        axes.legend(fontsize=8, frameon=False)
    elif others:
        axes.set_title(f"{len(series)} combinations of {', '.join(map(_short, others))}", fontsize=9)


def _results(columns, parameters):
    """The results that vary, in their order."""
    names = [name for name in columns if name not in parameters and name not in ("run", "replica", "seed", "status")]
    return [name for name in names if _is_numeric(columns[name]) and _varies(columns[name])]


def _is_numeric(column):
    return column.dtype.kind in "iufb"


def _varies(column):
    known = column[np.isfinite(column.astype(float))].astype(float)
    return len(known) > 0 and np.ptp(known) > SAME * np.abs(known).max()


def _is_wide(column):
    known = column[np.isfinite(column.astype(float))].astype(float)
    return len(known) > 2 and known.min() > 0 and known.max() >= WIDE * known.min()


def _follows(columns, name, x):
    """Whether a parameter has one value for each of x, so that it tells no curves apart."""
    pairs = set(zip(columns[x].tolist(), columns[name].tolist()))
    return len(pairs) == len(set(columns[x].tolist()))


def _error(values):
    """Standard error of the mean."""
    return np.std(values, ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.nan


def _colour(number, count):
    from matplotlib import colormaps

    return "#1f4e8c" if count == 1 else colormaps["viridis"](0.9 * number / (count - 1))


def _short(name):
    return name.rpartition(".")[2] if not name.rpartition(".")[2].isdigit() else ".".join(name.split(".")[-2:])


def _sortable(key):
    return [(isinstance(value, str), value) for value in key]
