"""edmd.pack for shapes and numbers that are not the demo's."""

import independent
import numpy as np
import pytest

import edmd
from edmd.trajectory import read_system


@pytest.mark.parametrize(("n", "semi_axes", "least"), [
    (50, (1.25, 1, 0.8), 0.66), (49, (1, 1, 1), 0.57), (32, (1, 1, 1), 0.57), (33, (1, 1, 0.5), 0.60), (108, (0.5, 0.5, 2.0), 0.45),
    (40, (2.0, 1, 1), 0.60),
])
def test_shapes_and_numbers(n, semi_axes, least):
    packing = edmd.pack(n, semi_axes, rate=3e-2, seed=2, until_pressure=1e4, melt=50)
    system = packing.system
    assert system.n == n
    assert packing.packing_fraction == pytest.approx(independent.packing_fraction(system), rel=1e-13)
    assert least < packing.packing_fraction < 0.78
    assert packing.pressure >= 1e4
    assert independent.smallest_scale(system) > 1 - 1e-9
    ratio = system.semi_axes / system.semi_axes[:, :1]
    assert np.abs(ratio - np.array(semi_axes) / semi_axes[0]).max() < 1e-13
    assert packing.contact_numbers.shape == packing.rattlers.shape == (n,)
    assert packing.collisions > 25 * n


def test_one_seed_one_packing(tmp_path):
    a, b, other = (edmd.pack(32, (1, 1, 1.5), rate=5e-2, seed=seed, until_pressure=1e3) for seed in (4, 4, 5))
    assert independent.same_bits(a.system, b.system)
    assert not independent.same_bits(a.system, other.system)
    written = edmd.pack(32, (1, 1, 1.5), rate=5e-2, seed=4, until_pressure=1e3, output=tmp_path / "run.h5md")
    assert independent.same_bits(a.system, written.system)
    assert np.array_equal(read_system(tmp_path / "run.h5md").positions, a.system.positions)


def test_contacts_and_rattlers():
    packing = edmd.pack(48, (1, 1, 1), rate=1e-3, seed=2, until_pressure=1e9)
    assert np.array_equal(packing.contact_numbers, independent.contact_counts(packing.system, 1e-6))
    assert (packing.contact_numbers[packing.rattlers] < 6).all()
    assert (packing.contact_numbers[~packing.rattlers] >= 4).all()
    held = packing.system.n - packing.rattlers.sum()
    assert packing.mean_contact_number == pytest.approx(6 - 4 / held, abs=0.15)         # isostatic: 3 N - 2 contacts; the faintest are open


@pytest.mark.parametrize(("changes", "names"), [
    ({"n": 0}, "n"), ({"n": 7}, "n"), ({"n": 32.5}, "n"), ({"n": "many"}, "n"), ({"semi_axes": (1, 1)}, "semi_axes"),
    ({"semi_axes": (1, 1, -1)}, "semi_axes"), ({"rate": 0}, "rate"), ({"rate": -1e-3}, "rate"), ({"rate": np.nan}, "rate"),
    ({"until_pressure": 0}, "until_pressure"), ({"until_pressure": np.inf}, "until_pressure"),
    ({"start_fraction": 0.0}, "start_fraction"), ({"rate": 10.0}, "rate"),
    ({"start_fraction": 0.99}, "start_fraction"), ({"melt": -1}, "melt"), ({"contact_gap": 0}, "contact_gap"), ({"seed": -1}, "seed"),
    ({"seed": "random"}, "seed"), ({"n": 8, "semi_axes": (0.1, 0.1, 5)}, "(n|box)"),
])
def test_bad_input_is_refused_by_name_before_anything_is_written(changes, names, tmp_path):
    arguments = {"n": 32, "semi_axes": (1, 1, 1), "rate": 0.1, "until_pressure": 100, "output": tmp_path / "run.h5md", **changes}
    with pytest.raises(ValueError, match=rf"\b{names}\b"):
        edmd.pack(**arguments)
    assert list(tmp_path.iterdir()) == []
