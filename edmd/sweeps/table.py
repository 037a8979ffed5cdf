"""The table of a sweep: a row a run, a column a number; CSV always, Parquet where pyarrow is there."""

import csv
import io
from pathlib import Path

import numpy as np

from edmd.sweeps.design import flat
from edmd.sweeps.results import write_whole

CSV, PARQUET = "table.csv", "table.parquet"
OWN = ("run", "replica", "seed", "status")


def table_of(runs, results, failed):
    """Columns as numpy arrays: run, replica, seed, status (done, failed or missing), then parameters, then results. Lists and tables among
    the parameters have a column an entry (system.semi_axes.2). Numbers that a run has not are nan, texts empty."""
    rows = []
    for run in runs:
        result = results.get(run.name)
        status = "done" if result is not None else "failed" if run.name in failed else "missing"
        own = dict(zip(OWN, (run.name, run.replica, run.seed, status)))
        rows.append((own, flat_parameters(run), result or {}))
    columns = {}
    for part in range(3):
        for name in dict.fromkeys(name for row in rows for name in row[part]):
            columns[name if name not in columns else f"result.{name}"] = _column([row[part].get(name) for row in rows])
    return columns


def flat_parameters(run):
    """The parameters of a run, as the columns that they are."""
    return flat(run.parameters) if run.parameters else {}


def write_table(directory, columns):
    """-> the paths written."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(column.tolist() for column in columns.values())))
    written = [Path(directory) / CSV]
    write_whole(written[0], text.getvalue().encode())
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        (Path(directory) / PARQUET).unlink(missing_ok=True)         # of an older table
        return written
    data = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(pyarrow.table({name: pyarrow.array(column.tolist()) for name, column in columns.items()}), data)
    written.append(Path(directory) / PARQUET)
    write_whole(written[1], data.getvalue().to_pybytes())
    return written


def _column(values):
    """Whole numbers, truths, numbers, or texts, the narrowest that holds them all."""
    known = [value for value in values if value is not None]
    for kind in (bool, int):
        if len(known) == len(values) and all(type(value) is kind for value in known):
            return np.array(values)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in known):
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    return np.array(["" if value is None else str(value) for value in values], dtype=object)
