"""How did the pressure and the density go? The dense series of a run as curves."""

from __future__ import annotations

import json
import os

import numpy as np

from analysis.blocks import weighted_mean
from analysis.reader import PARTICLES, RunFile
from analysis.style import BLUE, ORANGE, panels, plain_ticks
from ccd.annotations import AnyPath, Array, ArrayLike

STANDS_STILL = 1e-9             # packing fraction, temperature: a spread below it is rounding
PRESSURE = r"reduced pressure $PV/nkT$"


def read_log(path: AnyPath) -> dict[str, Array]:
    """The dense series of an edmd file.

    A dict of arrays (M,), `time`, `collisions`, `packing_fraction`, `reduced_pressure` and the others: the M rows that are whole in all.
    """
    with RunFile(os.fspath(path)) as file:
        log = {name: values[()] for name, values in file["edmd/log"].items()}
    rows = min(map(len, log.values()))
    return {name: values[:rows] for name, values in log.items()}


def interval_starts(path, log):
    """When the intervals (M,) began whose means the rows of a log are; they end at `log["time"]`."""
    with RunFile(os.fspath(path)) as file:
        begun = file[f"{PARTICLES}/position/time"][0]
    return np.concatenate([[begun], log["time"][:-1]])


def is_at_rest(packing_fraction):
    """Does the packing fraction stand still, but for rounding?"""
    return np.ptp(packing_fraction) <= STANDS_STILL


def plot_curve(x: ArrayLike, y: ArrayLike, output: AnyPath, error: ArrayLike | None = None, x_label: str = "", y_label: str = "",
               x_scale: str = "linear", y_scale: str = "linear") -> str:
    """Draw one result, y (m,) against x (m,), into `output`, with error bars of one standard error where `error` (m,) is given.

    As `plot_curve(*[results[name] for name in ("r", "g")], "g.pdf", results.error, "r", "g(r)")`. Scales are those of matplotlib: "linear",
    "log", whose axes leave out what is not positive. Points that are nan are left out, and bars that are nan. Returns the path written.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    bars = np.full(x.shape, np.nan) if error is None else np.asarray(error, dtype=float)
    if x.ndim != 1 or not x.shape == y.shape == bars.shape:
        raise ValueError(f"x, y, error have shapes {x.shape}, {y.shape}, {bars.shape}: expected one length (m,)")
    shown = ((x > 0) | (x_scale != "log")) & ((y > 0) | (y_scale != "log"))
    x, y, bars = x[shown], y[shown], bars[shown]
    figure, axes = panels()
    _curve(axes, x, y, x_label, y_label)
    if error is not None:
        axes.errorbar(x, y, yerr=bars, fmt="none", ecolor=BLUE, elinewidth=0.8, capsize=1.5)
    axes.set(xscale=x_scale, yscale=y_scale)
    plain_ticks(axes)
    figure.savefig(output, dpi=200)
    return os.fspath(output)


def plot_compression(path: AnyPath, output: AnyPath, title: bool = True) -> str:
    """Draw the course of a run into `output` (a name that ends as any format of matplotlib: .png, .pdf, .svg).

    A compression: the packing fraction against time, and the reduced pressure P V / (n kT), on a logarithmic axis, against
    the packing fraction. At a fixed packing fraction: the reduced pressure against time, and the temperature, or where that stands still
    the collision rate; each with its mean over time and the standard error of that by blocks (`block_error`), as a band. `title` gives the
    bodies and the parameters above. Returns the path written. ValueError when the file's log is empty.
    """
    log = read_log(path)
    if len(log["time"]) == 0:
        raise ValueError(f"path: {path} has no entries in its log yet; at least one is needed")
    figure, (left, right) = panels(1, 2, (9.0, 3.9))
    if not is_at_rest(log["packing_fraction"]):
        _curve(left, log["time"], log["packing_fraction"], "time", r"packing fraction $\phi$")
        _curve(right, log["packing_fraction"], log["reduced_pressure"], r"packing fraction $\phi$", PRESSURE)
        right.set_yscale("log")
    else:
        lengths = log["time"] - interval_starts(path, log)
        _curve_and_mean(left, log["time"], log["reduced_pressure"], lengths, PRESSURE)
        warm = log["temperature"][np.isfinite(log["temperature"])]
        steady = len(warm) > 0 and np.ptp(warm) <= STANDS_STILL * warm.max()
        name, label = ("collision_rate", "collisions per body and time") if steady else ("temperature", "temperature $kT$")
        _curve_and_mean(right, log["time"], log[name], lengths, label)
    if title:
        figure.suptitle(describe(path), fontsize=10)
    figure.savefig(output, dpi=200)
    return os.fspath(output)


def _curve(axes, x, y, x_label, y_label):
    axes.plot(x, y, color=BLUE, linewidth=1.4, marker="." if len(x) < 60 else None)
    axes.set(xlabel=x_label, ylabel=y_label)


def _curve_and_mean(axes, time, values, lengths, label):
    """A series at rest, thin, with its mean and error; its values are means over intervals of these lengths that end at the times."""
    axes.plot(time, values, color=BLUE, linewidth=0.8, marker="." if len(time) < 60 else None, alpha=0.6)
    axes.set(xlabel="time", ylabel=label)
    known = np.isfinite(values) & (lengths > 0)
    if not known.any():
        return
    mean, error = weighted_mean(values[known] * lengths[known], lengths[known])
    axes.axhline(mean, color=ORANGE, linewidth=1.2)
    if np.isfinite(error):
        axes.axhspan(mean - error, mean + error, color=ORANGE, alpha=0.25, linewidth=0)
    axes.set_title(f"mean {in_words(mean, error)}", loc="right", fontsize=9)


def in_words(mean, error):
    """A mean and its error, to two digits of the error."""
    if not np.isfinite(error) or error <= 0:
        return f"{mean:.5g}"
    digits = max(0, 1 - int(np.floor(np.log10(error))))
    return f"{mean:.{digits}f} ± {error:.{digits}f}"


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
    rates = [f"{rate:g}" for stage in parameters.get("stage", ()) if "rate" in stage for rate in np.atleast_2d(stage["rate"])[:, -1]]
    words += [f"growth rate {', '.join(rates)}"] if rates else []
    return ", ".join([f"{len(shapes)} ellipsoids {shape}", *words])
