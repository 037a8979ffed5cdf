import h5py
import numpy as np
import pytest
from matplotlib.image import imread
from runs import fcc, write_run

import analysis
from analysis import style
from analysis.curves import describe, in_words

POSITIONS, CELL = fcc(2)


def write(path, packing_fraction, axes=(0.5, 0.5, 0.5), parameters=None):
    m = len(packing_fraction)
    noise = 1 + 0.02 * np.sin(np.arange(m))
    log = {
        "time": np.linspace(0, 50, m),
        "collisions": np.arange(m) * 1000,
        "packing_fraction": packing_fraction,
        "reduced_pressure": np.r_[np.full(min(m, 1), np.nan), 3 / (1 - packing_fraction[1:] / 0.71) * noise[1:]],
        "pressure": np.ones(m),
        "temperature": noise,
        "collision_rate": np.ones(m),
    }
    return write_run(path, POSITIONS, [1, 0, 0, 0], axes, CELL, [0], log=log, parameters=parameters)


@pytest.mark.parametrize("packing_fraction", [0.7099 - 0.4 * np.exp(-np.linspace(0, 8, 80)), np.full(80, 0.4)])
def test_a_run_is_drawn(tmp_path, packing_fraction):
    path = write(tmp_path / "run.h5md", packing_fraction)
    output = tmp_path / "curves.png"
    assert analysis.plot_compression(path, output) == str(output)
    pixels = imread(output)[..., :3]
    line = np.abs(pixels - np.array([0x1F, 0x4E, 0x8C]) / 255).max(axis=2) < 0.4
    half = line.shape[1] // 2
    assert line[:, :half].sum() > 500
    assert line[:, half:].sum() > 500


def test_a_compression_and_a_run_at_rest_have_other_axes(tmp_path):
    compression = write(tmp_path / "a.h5md", np.linspace(0.3, 0.7, 30))
    equilibrium = write(tmp_path / "b.h5md", np.full(30, 0.4))
    expected = {compression: ("packing fraction", "reduced pressure"), equilibrium: ("reduced pressure", "temperature")}
    for path, labels in expected.items():
        analysis.plot_compression(path, tmp_path / "out.svg")
        text = (tmp_path / "out.svg").read_text()
        assert all(label in text for label in labels)


def test_a_run_at_rest_shows_its_mean_and_error_and_what_varies(tmp_path):
    path = write(tmp_path / "run.h5md", np.full(200, 0.4))
    analysis.plot_compression(path, tmp_path / "out.svg", title=False)
    text = (tmp_path / "out.svg").read_text()
    temperature, error = analysis.mean_pressure(path)["temperature"]
    assert f"mean {in_words(temperature, error)}" in text
    assert "±" in text
    assert "ellipsoids" not in text
    with h5py.File(path, "a") as file:
        file["edmd/log/temperature"][:] = 1.0
    analysis.plot_compression(path, tmp_path / "out.svg")
    text = (tmp_path / "out.svg").read_text()
    assert "temperature" not in text
    assert "collisions per body and time" in text


@pytest.mark.parametrize(("mean", "error", "words"), [(7.94012, 0.0604, "7.940 ± 0.060"), (1234.5, 12.0, "1234 ± 12"),
                                                      (0.5, np.nan, "0.5"), (2.0, 0.0, "2")])
def test_a_mean_is_told_to_two_digits_of_its_error(mean, error, words):
    assert in_words(mean, error) == words


def test_the_title_tells_bodies_and_parameters(tmp_path):
    path = write(tmp_path / "run.h5md", np.full(3, 0.4), (0.5, 0.5, 0.75), {"n": 32, "rate": 1e-4, "seed": 7, "nested": {"a": 1}})
    assert describe(path) == "32 ellipsoids 1:1:1.5, rate 0.0001, seed 7"


def test_an_empty_log_is_refused(tmp_path):
    path = write(tmp_path / "run.h5md", np.empty(0))
    with pytest.raises(ValueError, match=r"path: .* no entries in its log"):
        analysis.plot_compression(path, tmp_path / "out.png")


def test_a_result_is_drawn_with_its_errors(tmp_path):
    x = np.linspace(0, 5, 20)
    for error, marks in ((None, 0), (np.full(20, 0.3), 20)):
        assert analysis.plot_curve(x, np.sin(x), tmp_path / "curve.svg", error, "r", "g(r)") == str(tmp_path / "curve.svg")
        text = (tmp_path / "curve.svg").read_text()
        bars = text.split('id="LineCollection_1"')[1].split("</g>")[0].count("<path") if "LineCollection" in text else 0
        assert bars == marks
        assert "g(r)" in text
    with pytest.raises(ValueError, match="shapes"):
        analysis.plot_curve(x, np.sin(x), tmp_path / "curve.svg", np.ones(3))


def test_a_log_whose_last_row_is_there_in_part_is_read_without_it(tmp_path):
    path = write(tmp_path / "run.h5md", np.linspace(0.3, 0.7, 5))
    with h5py.File(path, "a") as file:
        del file["edmd/log/pressure"]
        file["edmd/log/pressure"] = np.ones(4)
    assert {len(values) for values in analysis.read_log(path).values()} == {4}


def test_the_log_is_read_as_it_stands(tmp_path):
    log = analysis.read_log(write(tmp_path / "run.h5md", np.linspace(0.3, 0.7, 5)))
    np.testing.assert_array_equal(log["packing_fraction"], np.linspace(0.3, 0.7, 5))
    assert set(log) == {"time", "collisions", "packing_fraction", "reduced_pressure", "pressure", "temperature", "collision_rate"}


@pytest.mark.parametrize(("limits", "labels"), [((0.3, 6.0), ["0.5", "1", "2", "5"]), ((1e-3, 1e2), None)])
def test_short_logarithmic_axes_have_plain_numbers(limits, labels):
    figure, axes = analysis.panels()
    axes.set(xscale="log", xlim=limits)
    style.plain_ticks(axes)
    figure.canvas.draw()
    low, high = axes.get_xlim()
    shown = [text.get_text() for text, at in zip(axes.get_xticklabels(), axes.get_xticks()) if low <= at <= high]
    assert shown == labels if labels else all("10^" in text for text in shown)
