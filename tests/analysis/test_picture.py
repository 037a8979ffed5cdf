import subprocess
import sys

import MDAnalysis as mda
import numpy as np
import pytest
from matplotlib.image import imread
from PIL import Image
from runs import random_quaternions, write_run
from scipy.spatial.transform import Rotation

import analysis
from analysis import colours

UPRIGHT = np.array([[1.0, 0, 0, 0]])
GREY = np.array([[0.4, 0.4, 0.4]])
RED, GREEN, BLUE = np.eye(3)


def camera(view):
    """Right and up of someone who looks from `view`, with z up: written anew here."""
    toward = np.asarray(view, dtype=float) / np.linalg.norm(view)
    up = np.array([0, 0, 1]) - toward[2] * toward
    up /= np.linalg.norm(up)
    return np.cross(up, toward), up


@pytest.fixture
def few_lamps(monkeypatch):
    """They take most of the time, and what these tests look at does not depend on them."""
    monkeypatch.setattr("analysis.shading.SKY_LAMPS", 6)
    monkeypatch.setattr("analysis.shading.KEY_LAMPS", 2)


@pytest.mark.parametrize("view", [(0.42, -1, 0.36), (0, 0, 1), (1, 0, 0), (-2, 1, -3)])
def test_the_silhouette_has_the_projected_area(view, few_lamps):
    """pi sqrt(m^T adj(S) m), S = R diag(axes^2) R^T; the scale is known since the silhouette fills the picture but for 3 %."""
    q = random_quaternions(np.random.default_rng(3), 1)
    axes = np.array([[1.0, 0.5, 0.3]])
    rotation = Rotation.from_quat(q[0, [1, 2, 3, 0]]).as_matrix()
    covariance = rotation @ np.diag(axes[0] ** 2) @ rotation.T
    toward = np.array(view) / np.linalg.norm(view)
    area = np.pi * np.sqrt(toward @ (np.linalg.inv(covariance) * np.linalg.det(covariance)) @ toward)
    right, up = camera(view) if view[0] or view[1] else (np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))
    sizes = 2 * np.sqrt([right @ covariance @ right, up @ covariance @ up])
    pixels = analysis.image((np.array([[3.0, -2.0, 5.0]]), q, axes), 0 * GREY, size=(300, 300), view=view)
    shape = (pixels < 188).any(axis=2)  # half of the light of white: pixels of which the body covers more than half
    scale = sizes.max() / (300 / 1.03)
    assert shape.sum() * scale**2 == pytest.approx(area, rel=0.01)
    widths = np.ptp(np.flatnonzero(shape.any(axis=0))) + 1, np.ptp(np.flatnonzero(shape.any(axis=1))) + 1
    np.testing.assert_allclose(np.array(widths) * scale, sizes, atol=2 * scale)


@pytest.mark.parametrize("view", [(0.42, -1, 0.36), (-1, -2, 0.5), (1, 1, -0.4)])
def test_nothing_is_mirrored(view, few_lamps):
    """Four small balls stand where a right-handed camera puts them: black at the origin; red, green and blue along x, y and z."""
    positions = np.concatenate([np.zeros((1, 3)), 2 * np.eye(3)])
    paint = np.array([0 * RED, RED, GREEN, BLUE])
    balls = positions, np.tile(UPRIGHT, (4, 1)), np.full((4, 3), 0.2)
    pixels = analysis.image(balls, paint, size=(200, 200), view=view).astype(float)
    for k, name in ((1, "x"), (2, "y"), (3, "z")):
        hue = pixels[..., k - 1] - np.delete(pixels, k - 1, axis=2).max(axis=2)
        row, column = (np.average(i, weights=hue > 60) for i in np.indices(hue.shape))
        black_row, black_column = (np.average(i, weights=(pixels.max(axis=2) < 120)) for i in np.indices(hue.shape))
        right, up = camera(view)
        moved = np.array([column - black_column, black_row - row])
        expected = np.array([right[k - 1], up[k - 1]])
        assert moved @ expected / np.linalg.norm(moved) / np.linalg.norm(expected) > 0.99, name


def test_the_nearer_body_hides_the_other(few_lamps):
    positions = np.array([[0, -3.0, 0], [0, 3.0, 0]])
    bodies = positions, np.tile(UPRIGHT, (2, 1)), np.array([[0.5] * 3, [1.0] * 3])
    front = analysis.image(bodies, np.array([RED, BLUE]), size=(80, 80), view=(0, -1, 0))
    back = analysis.image(bodies, np.array([RED, BLUE]), size=(80, 80), view=(0, 1, 0))
    assert front[40, 40].argmax() == 0
    assert back[40, 40].argmax() == 2
    assert front[40, 10].argmax() == 2


def test_light_comes_from_the_upper_left():
    pixels = analysis.image((np.zeros((1, 3)), UPRIGHT, np.full((1, 3), 0.5)), GREY, size=(90, 90), view=(0, -1, 0)).mean(axis=2)
    assert pixels[25, 30] > pixels[65, 30] + 20
    assert pixels[25, 30] > pixels[25, 60] + 5


def test_a_body_in_the_way_of_the_light_casts_a_shadow():
    def brightness_of_the_red_one(blocker):
        positions = np.array([[0, 0, 0], blocker])
        bodies = positions, np.tile(UPRIGHT, (2, 1)), np.full((2, 3), 0.5)
        pixels = analysis.image(bodies, np.array([RED, BLUE]) * 0.5, size=(100, 100), view=(0, -1, 0)).astype(float)
        return pixels[pixels[..., 0] > pixels[..., 2] + 30][:, 0].mean()

    assert brightness_of_the_red_one([-1.35, -1.92, 1.86]) < brightness_of_the_red_one([1.35, -1.92, 1.86]) - 15


def test_the_cell_has_dark_edges(few_lamps):
    bodies = np.array([[5.0, 5, 5]]), UPRIGHT, np.full((1, 3), 0.5)
    pixels = analysis.image(bodies, GREY, cell=10 * np.eye(3), size=(400, 400), view=(0, 0, 1))
    for row in (pixels[200], pixels[:, 200]):  # the cell's side is 1/1.03 of the picture's
        assert row[4:8].min() < 190
        assert row[-8:-4].min() < 190
        assert row[[2, 20, 150, -3]].min() == 255


def test_colours_are_the_same_for_both_ends_and_differ_with_direction():
    q = random_quaternions(np.random.default_rng(0), 50)
    axes = np.tile([1.0, 1.0, 2.0], (50, 1))
    flip = Rotation.from_quat(q[:, [1, 2, 3, 0]]) * Rotation.from_rotvec([np.pi, 0, 0])
    flipped = flip.as_quat()[:, [3, 0, 1, 2]]
    ours = colours.orientation_colours(q, axes)
    np.testing.assert_allclose(colours.orientation_colours(flipped, axes), ours, atol=1e-12)
    assert ours.min() >= 0
    assert ours.max() <= 1
    along_x, along_y, along_z = (colours.orientation_colours(UPRIGHT, [row])[0] for row in (np.eye(3) + 1.0))
    assert min(np.abs(along_x - along_y).max(), np.abs(along_x - along_z).max(), np.abs(along_y - along_z).max()) > 0.2
    assert np.ptp(along_z) < 0.02


def test_oklab_of_known_colours():
    np.testing.assert_allclose(colours.linear_rgb(np.array([[1.0, 0, 0], [0, 0, 0]])), [[1, 1, 1], [0, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(colours.linear_rgb(np.array([[0.627955, 0.224863, 0.125846]])), [RED], atol=1e-4)  # Ottosson's red
    np.testing.assert_array_equal(colours.encoded(np.array([0.0, 0.2140411, 1.0])), [0, 127, 255])


@pytest.fixture
def run(tmp_path):
    rng = np.random.default_rng(1)
    positions = np.array([rng.random((20, 3)) * 5, rng.random((20, 3)) * 5])
    q = random_quaternions(rng, 40).reshape(2, 20, 4)
    return write_run(tmp_path / "run.h5md", positions, q, (0.4, 0.4, 0.7), 5 * np.eye(3), [0, 1], species=np.arange(20) % 2)


@pytest.mark.parametrize("colour", ["orientation", "species", "contacts"])
def test_render_writes_a_png(run, tmp_path, colour):
    output = tmp_path / "out.png"
    assert analysis.render(run, output, colour=colour, size=(120, 90)) == str(output)
    pixels = imread(output)
    assert pixels.shape[:2] == (90, 120)
    assert pixels[0, 0].min() == 1.0
    assert 0.15 < (pixels.min(axis=2) < 0.97).mean() < 0.9


def test_render_shows_the_frame_that_was_asked_for_and_leaves_the_universe_there(run, tmp_path, few_lamps):
    universe = mda.Universe(run)
    pictures = []
    for frame in (0, 1, -1):
        analysis.render(universe, tmp_path / "out.png", frame=frame, size=(60, 60))
        pictures.append(imread(tmp_path / "out.png"))
        assert universe.trajectory.frame == 0
    assert np.abs(pictures[0] - pictures[1]).max() > 0.2
    np.testing.assert_array_equal(pictures[1], pictures[2])


def test_a_series_is_drawn_with_one_camera(tmp_path, few_lamps):
    """One small body, in a corner and then in the middle: the cell stays where it is in the pictures."""
    positions = np.array([[[0.1, 0.1, 0.1]], [[2.5, 2.5, 2.5]]])
    run = write_run(tmp_path / "run.h5md", positions, UPRIGHT, (1.0, 1.0, 1.0), 5 * np.eye(3), [0, 1])
    paths = analysis.render_series(run, tmp_path / "movie", size=(160, 160))
    assert paths == [str(tmp_path / "movie" / name) for name in ("00000.png", "00001.png")]
    first, second = (imread(path)[..., :3] for path in paths)
    frame = [(picture.max(axis=2) < 0.35) for picture in (first, second)]
    assert (frame[0] & frame[1]).sum() > 0.5 * max(frame[0].sum(), frame[1].sum()) > 50
    analysis.render(run, tmp_path / "alone.png", frame=1, size=(160, 160))
    assert (frame[0] & (imread(tmp_path / "alone.png")[..., :3].max(axis=2) < 0.35)).sum() < 0.3 * frame[0].sum()
    assert len(analysis.render_series(run, tmp_path / "back", [-1, 0], size=(160, 160))) == 2
    np.testing.assert_array_equal(imread(tmp_path / "back" / "00000.png")[..., :3], second)


def test_a_movie_is_one_file(run, tmp_path, few_lamps):
    assert analysis.render_series(run, tmp_path / "movie.gif", size=(60, 50), per_second=10) == [str(tmp_path / "movie.gif")]
    with Image.open(tmp_path / "movie.gif") as movie:
        assert (movie.n_frames, movie.size, movie.info["duration"], movie.info["loop"]) == (2, (60, 50), 100, 0)
    with pytest.raises(ValueError, match="per_second: 0"):
        analysis.render_series(run, tmp_path / "other.gif", per_second=0)
    with pytest.raises(ValueError, match="frame: 7"):
        analysis.render_series(run, tmp_path / "other", [0, 7])
    assert not (tmp_path / "other").exists()


REFUSED = [("colour", "blue"), ("frame", 2), ("frame", -3), ("size", (0, 9)), ("view", (0, 0, 0))]


@pytest.mark.parametrize(("name", "value"), REFUSED)
def test_what_cannot_be_drawn_is_refused(run, tmp_path, name, value):
    with pytest.raises(ValueError, match=f"{name}: "):
        analysis.render(run, tmp_path / "out.png", **{name: value})
    assert not (tmp_path / "out.png").exists()


def test_importing_analysis_does_not_load_matplotlib_s_pyplot_or_the_ray_caster():
    script = "import sys, analysis; assert not {'matplotlib.pyplot', 'analysis.picture', 'analysis.shading'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", script], check=True)
