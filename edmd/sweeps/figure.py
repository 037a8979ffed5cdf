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
WIDE = 10                       # ratio of the largest to the smallest value from which on an axis is logarithmic
DECADES = 300                   # the same ratio, from which on only powers of ten have labels
BAR = {"elinewidth": 0.9, "capsize": 2.5, "markersize": 4, "linewidth": 1.3}


class Series(NamedTuple):
    """One curve: what its points share, and mean and standard error over the replicas at each x (nan: a single replica)."""

    label: str
    x: np.ndarray
    mean: np.ndarray
    error: np.ndarray


def draw_summary(directory, columns, parameters, x=None, y=None):
    """Draw results y (names; default: the first that vary) against the parameter x (default: the first that varies). -> the paths
    written: none when there is no result, or none that varies."""
    if "done" not in columns["status"]:
        return []
    _check_names(columns, x, y)
    varied = [name for name in parameters if len(set(columns[name].tolist())) > 1]
    numeric = [name for name in varied if _is_numeric(columns[name])]
    x = x or (numeric or ["replica"])[0]
    y = y or _results(columns, parameters)[:PANELS]
    if not y:
        return []
    from matplotlib.figure import Figure

    others = [name for name in varied if name != x and not _follows(columns, name, x)]
    loose = [name for name in numeric if name not in (x, *others) and not _in_order(columns, name, x)]
    across = min(len(y), 2)
    figure = Figure(figsize=(5.2 * across, 3.9 * -(-len(y) // across)), layout="constrained")
    panels = figure.subplots(-(-len(y) // across), across, squeeze=False).ravel()
    for axes, name in zip(panels, y):
        if loose or x == "replica":
            _cloud(axes, columns, x, name, loose[:1])
        else:
            _curves(axes, columns, x, name, others)
        _finish(axes, columns, x, name)
    for axes in panels[len(y):]:
        axes.remove()
    picture = io.BytesIO()
    figure.savefig(picture, dpi=150, format="png")
    write_whole(Path(directory) / FIGURE, picture.getvalue())
    return [Path(directory) / FIGURE]


def _check_names(columns, x, y):
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
        mean, error = np.array([(np.mean(points[one]), _error(points[one])) for one in at]).T
        made.append(Series(", ".join(f"{_short(name)} = {_brief(value)}" for name, value in zip(others, key)), np.array(at), mean, error))
    return made


def _curves(axes, columns, x, y, others):
    series = series_of(columns, x, y, others)
    for number, one in enumerate(series):
        axes.errorbar(one.x, one.mean, yerr=np.nan_to_num(one.error), fmt="o-", color=_colour(number, len(series)), label=one.label, **BAR)
    if others and len(series) <= LEGEND:
        axes.legend(fontsize=8, frameon=False)
    elif others:
        axes.set_title(f"{len(series)} combinations of {', '.join(map(_short, others))}", fontsize=9)


def _cloud(axes, columns, x, y, coloured_by):
    """Points that no curve joins, such as those of a random design, coloured by another parameter."""
    for one in series_of(columns, x, y, []):
        axes.errorbar(one.x, one.mean, yerr=np.nan_to_num(one.error), fmt="none", ecolor="0.6", **BAR)
        if coloured_by:
            other = dict(zip(columns[x].tolist(), columns[coloured_by[0]].tolist()))
            shown = axes.scatter(one.x, one.mean, c=[other[value] for value in one.x.tolist()], s=18, zorder=3,
                                 norm="log" if _is_wide(columns[coloured_by[0]]) else None)
            axes.figure.colorbar(shown, ax=axes, label=coloured_by[0])
        else:
            axes.scatter(one.x, one.mean, color=_colour(0, 1), s=18, zorder=3)


def _finish(axes, columns, x, y):
    from matplotlib.ticker import MaxNLocator

    axes.set_xlabel(x)
    axes.set_ylabel(y.replace("_", " "))
    for axis, name in ((axes.xaxis, x), (axes.yaxis, y)):
        if _is_wide(columns[name]):
            _make_logarithmic(axis, columns[name])
        elif columns[name].dtype.kind == "i":
            axis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(True, color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


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


def _make_logarithmic(axis, column):
    from matplotlib.ticker import LogLocator, NullFormatter

    known = column[np.isfinite(column.astype(float))]
    axis.axes.set(**{f"{axis.axis_name}scale": "log"})
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if known.max() < DECADES * known.min() else (1,)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def _follows(columns, name, x):
    """Whether a parameter has one value for each of x, so that it tells no curves apart."""
    pairs = set(zip(columns[x].tolist(), columns[name].tolist()))
    return len(pairs) == len(set(columns[x].tolist()))


def _in_order(columns, name, x):
    """Whether a parameter rises or falls with x all the way."""
    steps = np.diff([value for _, value in sorted(set(zip(columns[x].tolist(), columns[name].tolist())))])
    return bool((steps >= 0).all() or (steps <= 0).all())


def _error(values):
    """Standard error of the mean."""
    return np.std(values, ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.nan


def _colour(number, count):
    from matplotlib import colormaps

    return "#1f4e8c" if count == 1 else colormaps["viridis"](0.8 * number / (count - 1))


def _short(name):
    return name.rpartition(".")[2] if not name.rpartition(".")[2].isdigit() else ".".join(name.split(".")[-2:])


def _brief(value):
    return f"{value:g}" if isinstance(value, float) else str(value)


def _sortable(key):
    return [(isinstance(value, str), value) for value in key]
