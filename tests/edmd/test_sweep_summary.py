"""The summary of a sweep: means and errors over replicas, what is drawn when nothing is said, columns of mixed and missing values."""

import numpy as np
import pytest

from edmd.sweeps.design import Planned
from edmd.sweeps.figure import draw_summary, series_of
from edmd.sweeps.table import table_of, write_table


def columns(points, results):
    """The table of runs with these parameters and results."""
    runs = [Planned(f"run{i}", point, 0, i) for i, point in enumerate(points)]
    return table_of(runs, {f"run{i}": result for i, result in enumerate(results) if result is not None}, {"run1": "it failed"})


def test_means_and_standard_errors_over_replicas():
    table = columns([{"x": x, "k": k} for k in ("a", "b") for x in (1, 2) for _ in range(3)],
                    [{"y": y} for y in (1, 2, 6, 4, 4, 4, 0, 0, 3, 1, 2, 3)])
    first, second = series_of(table, "x", "y", ["k"])
    assert (first.label, second.label) == ("k = a", "k = b")
    assert first.x.tolist() == [1, 2]
    assert first.mean.tolist() == [3, 4]
    assert first.error == pytest.approx([np.sqrt(7 / 3), 0])    # variance 7 of three values
    assert second.mean.tolist() == [1, 2]
    assert second.error == pytest.approx([1, 1 / np.sqrt(3)])


def test_one_replica_has_no_error_and_failed_runs_do_not_count():
    table = columns([{"x": 1}, {"x": 2}, {"x": 3}], [{"y": 1.0}, None, {"y": 2.0}])
    assert table["status"].tolist() == ["done", "failed", "done"]
    (series,) = series_of(table, "x", "y", [])
    assert series.x.tolist() == [1, 3]
    assert np.isnan(series.error).all()


def test_columns_of_what_runs_have_and_have_not(tmp_path):
    table = columns([{"n": 3, "axes": [1, 2.5], "name": "a", "on": True}, {"n": 4, "axes": 2.0, "name": "b", "on": False},
                     {"n": 5, "frames": {"time": 1}, "name": "c", "on": True}], [{"y": 1, "n": 7}, None, {"y": 2, "n": 8}])
    assert list(table)[:4] == ["run", "replica", "seed", "status"]
    assert list(table)[4:] == ["n", "axes.0", "axes.1", "name", "on", "axes", "frames.time", "y", "result.n"]
    assert table["n"].tolist() == [3, 4, 5]
    assert table["on"].dtype == bool
    assert np.array_equal(table["axes.0"], [1, np.nan, np.nan], equal_nan=True)
    assert np.array_equal(table["result.n"], [7, np.nan, 8], equal_nan=True)
    write_table(tmp_path, table)
    assert (tmp_path / "table.csv").read_text().splitlines()[2] == "run1,0,1,failed,4,nan,nan,b,False,2.0,nan,nan,nan"


@pytest.mark.parametrize(("points", "results"), [
    ([{"x": x} for x in (1, 2, 3)], [{"y": x, "z": 5} for x in (1, 2, 3)]),    # a curve
    ([{"x": x, "k": k} for x in (0.01, 1, 10) for k in "ab"], [{"y": y} for y in range(1, 7)]),    # curves, logarithmic
    ([{"x": x, "k": x * k} for x in (1, 2, 3) for k in range(1, 12)], [{"y": y} for y in range(33)]),    # too many for a legend
    ([{"x": x, "k": k} for x, k in ((0.1, 3), (0.5, 1), (0.7, 2))], [{"y": y} for y in (1, 2, 5)]),    # a random design
    ([{"k": k} for k in "ab"], [{"y": 1}, {"y": 2}]),    # no number varies
    ([{}, {}, {}], [{"y": y} for y in (1, 2, 5)]),    # replicas alone
    ([{"x": x} for x in (1, 2, 3)], [{"y": 1}, None, {"y": 2}]),    # a run that failed
])
def test_every_kind_of_design_is_drawn(points, results, tmp_path):
    table = columns(points, results)
    (path,) = draw_summary(tmp_path, table, list(points[0]))
    assert path.read_bytes().startswith(b"\x89PNG")


def test_nothing_to_draw(tmp_path):
    assert draw_summary(tmp_path, columns([{"x": 1}, {"x": 2}], [{"y": 3}, {"y": 3}]), ["x"]) == []
    assert draw_summary(tmp_path, columns([{"x": 1}, {"x": 2}], [None, None]), ["x"], y=["y"]) == []
    assert list(tmp_path.iterdir()) == []


def test_a_result_that_is_not_there(tmp_path):
    with pytest.raises(ValueError, match=r"plot.y = 'hight': no such column of numbers \(did you mean height\?\)"):
        draw_summary(tmp_path, columns([{"x": 1}, {"x": 2}], [{"height": 3}, {"height": 4}]), ["x"], y=["hight"])
