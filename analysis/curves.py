"""How did the pressure and the density go? The dense series of a run as curves."""

import json
import os

import numpy as np

from analysis.reader import RunFile

STANDS_STILL = 1e-9             # packing fraction: a spread below it is rounding
COLOUR = "#1f4e8c"
PRESSURE = r"reduced pressure $PV/nk_BT$"


def read_log(path):
    """The dense series of an edmd file.

    A dict of arrays (M,), `time`, `collisions`, `packing_fraction`, `reduced_pressure` and the others: the M rows that are whole in all.
    """
    with RunFile(os.fspath(path)) as file:
        log = {name: values[()] for name, values in file["edmd/log"].items()}
    rows = min(map(len, log.values()))
    return {name: values[:rows] for name, values in log.items()}


def is_at_rest(packing_fraction):
    """Does the packing fraction stand still, but for rounding?"""
    return np.ptp(packing_fraction) <= STANDS_STILL


def plot_curve(x, y, output, error=None, x_label="", y_label=""):
    """Draw one result, y (m,) against x (m,), into `output`, with error bars of one standard error where `error` (m,) is given.

    As `plot_curve(*[results[name] for name in ("r", "g")], "g.pdf", results.error, "r", "g(r)")`. Points that are nan are left out.
    Returns the path written.
    """
    from matplotlib.figure import Figure

    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if x.ndim != 1 or x.shape != y.shape or (error is not None and np.shape(error) != x.shape):
        raise ValueError(f"x, y, error have shapes {x.shape}, {y.shape}, {np.shape(error)}: expected one length (m,)")
    figure = Figure(figsize=(4.8, 3.6), layout="constrained")
    axes = figure.subplots()
    _curve(axes, x, y, x_label, y_label)
    if error is not None:
        axes.errorbar(x, y, yerr=error, fmt="none", ecolor=COLOUR, elinewidth=0.8, capsize=1.5)
    figure.savefig(output, dpi=200)
    return os.fspath(output)


def plot_compression(path, output):
    """Draw the course of a run into `output` (a name that ends as any format of matplotlib: .png, .pdf, .svg).

    A compression: the packing fraction against time, and the reduced pressure P V / (n kT), on a logarithmic axis, against
    the packing fraction. At a fixed packing fraction: the reduced pressure and the temperature against time. The title
    gives the bodies and the parameters. Returns the path written. ValueError when the file's log is empty.
    """
    from matplotlib.figure import Figure

    log = read_log(path)
    if len(log["time"]) == 0:
        raise ValueError(f"path: {path} has no entries in its log yet; at least one is needed")
    figure = Figure(figsize=(9.0, 3.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    if not is_at_rest(log["packing_fraction"]):
        _curve(left, log["time"], log["packing_fraction"], "time", r"packing fraction $\phi$")
        _curve(right, log["packing_fraction"], log["reduced_pressure"], r"packing fraction $\phi$", PRESSURE)
        right.set_yscale("log")
    else:
        _curve(left, log["time"], log["reduced_pressure"], "time", PRESSURE)
        _show_mean(left, log["reduced_pressure"])
        _curve(right, log["time"], log["temperature"], "time", r"temperature $k_BT$")
        _show_mean(right, log["temperature"])
    figure.suptitle(describe(path), fontsize=10)
    figure.savefig(output, dpi=200)
    return os.fspath(output)


def _curve(axes, x, y, x_label, y_label):
    axes.plot(x, y, color=COLOUR, linewidth=1.4, marker="." if len(x) < 60 else None)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(True, color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _show_mean(axes, values):
    known = values[np.isfinite(values)]
    if len(known):
        axes.axhline(known.mean(), color="0.35", linewidth=0.9, linestyle="--")
        axes.set_title(f"mean {known.mean():.5g}", loc="right", fontsize=9)


def describe(path):
    """One line about a run: how many bodies of which shape, and its parameters."""
    with RunFile(os.fspath(path)) as file:
        shapes = file["particles/trajectory/semi_axes/value"][0]
        parameters = json.loads(file["edmd"].attrs["parameters"])
    ratios = np.unique((shapes / shapes.min(axis=1, keepdims=True)).round(6), axis=0)
    kinds = [":".join(f"{value:g}" for value in row) for row in ratios]
    shape = " and ".join(kinds) if len(kinds) <= 3 else f"of {len(kinds)} shapes"
    words = [f"{name.replace('_', ' ')} {value:g}" if isinstance(value, float) else f"{name.replace('_', ' ')} {value}"
             for name, value in parameters.items() if isinstance(value, (int, float, str)) and name != "n"]
    rates = [f"{stage['rate']:g}" for stage in parameters.get("stage", ()) if "rate" in stage]
    words += [f"growth rate {', '.join(rates)}"] if rates else []
    return ", ".join([f"{len(shapes)} ellipsoids {shape}", *words])
