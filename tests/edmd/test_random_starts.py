"""Random systems and thermal velocities."""

import subprocess
import sys

import fluids
import independent
import numpy as np
import pytest

import edmd


@pytest.mark.parametrize("packing_fraction", [0.01, 0.3, 0.5])
@pytest.mark.parametrize("semi_axes", [(1, 1, 1), (1, 1, 2), (1.25, 1, 0.8), (0.3, 0.3, 1.5)])
def test_random_system(semi_axes, packing_fraction):
    s = edmd.random_system(64, semi_axes, packing_fraction, seed=3)
    assert s.n == 64
    assert np.abs(s.semi_axes - semi_axes).max() < 1e-12
    assert s.packing_fraction == pytest.approx(packing_fraction, rel=1e-13)
    assert independent.packing_fraction(s) == pytest.approx(packing_fraction, rel=1e-13)
    assert independent.smallest_scale(s) > 1 - 1e-12
    assert np.array_equal(s.box, s.box[0, 0] * np.eye(3))


def test_random_system_is_random_and_repeats():
    a, b, other = (edmd.random_system(64, (1, 1, 2), 0.3, seed=seed) for seed in (3, 3, 4))
    assert independent.same_bits(a, b)
    assert abs(a.positions - other.positions).max() > 1
    # orientations without preference: the largest eigenvalue of Q of n random axes is about 1.2 sqrt(1 / n)
    u = independent.rotation_matrices(edmd.random_system(500, (1, 1, 2), 0.2, seed=1).orientations)[:, :, 2]
    assert np.linalg.eigvalsh(1.5 * u.T @ u / 500 - 0.5 * np.eye(3))[-1] < 0.12


def test_mixture():
    s = edmd.random_system((20, 10, 5), [(1, 1, 1), (0.5, 0.5, 2), (1.2, 1, 0.6)], 0.4, seed=3)
    assert np.bincount(s.species).tolist() == [20, 10, 5]
    for species, axes in enumerate([(1, 1, 1), (0.5, 0.5, 2), (1.2, 1, 0.6)]):
        assert s.semi_axes[s.species == species] == pytest.approx(np.tile(axes, ((s.species == species).sum(), 1)), rel=1e-12)
    assert independent.packing_fraction(s) == pytest.approx(0.4, rel=1e-13)
    assert independent.smallest_scale(s) > 1 - 1e-12
    edmd.Simulation(s).run(collisions=200).verify()


@pytest.mark.parametrize(("arguments", "names"), [
    ((0, (1, 1, 1), 0.3), "n"),
    ((-3, (1, 1, 1), 0.3), "n"),
    ((2.5, (1, 1, 1), 0.3), "n"),
    (((10, 10), (1, 1, 1), 0.3), "n"),
    ((10, [(1, 1, 1), (1, 1, 2)], 0.3), "n"),
    ((10, (1, 1), 0.3), "semi_axes"),
    ((10, (1, 1, -1), 0.3), "semi_axes"),
    ((10, (1, 1, np.nan), 0.3), "semi_axes"),
    ((32, (1, 1, 1), 0.0), "packing_fraction"),
    ((32, (1, 1, 1), 1.0), "packing_fraction"),
    ((32, (1, 1, 1), "dense"), "packing_fraction"),
    (("many", (1, 1, 1), 0.3), "n"),
    ((32, "round", 0.3), "semi_axes"),
])
def test_bad_random_systems_are_refused_by_name(arguments, names):
    with pytest.raises(ValueError, match=rf"^{names}\b"):
        edmd.random_system(*arguments)


def test_a_density_beyond_jamming_is_refused_in_words():
    """In a process of its own: it must say so, and not compress for ever. The time is for a machine that compiles all else meanwhile."""
    script = "import edmd; edmd.random_system(32, (1, 1, 1), 0.73, seed=1)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=240)
    assert done.stderr.strip().splitlines()[-1].startswith("ValueError: packing_fraction")


@pytest.mark.parametrize("temperature", [1.0, 0.3, 1e-6, 400.0])
@pytest.mark.parametrize("shape", fluids.SHAPES)
def test_thermalized(shape, temperature):
    """Exactly the temperature, by active degrees of freedom; no total momentum; the original untouched."""
    cold = fluids.fluid(shape, 32, 0.3)
    cold = edmd.System(cold.positions, cold.orientations, cold.semi_axes, cold.box, masses=np.linspace(0.5, 3, 32))
    s = edmd.thermalized(cold, seed=5, temperature=temperature)
    assert not cold.velocities.any()
    translation, rotation = independent.energies(s)
    active = {"sphere": [], "prolate": [0, 1], "oblate": [0, 1], "triaxial": [0, 1, 2]}[shape]
    freedoms = 3 * 32 - 3 + 32 * len(active)
    assert 2 * (translation + rotation[active].sum()) / freedoms == pytest.approx(temperature, rel=1e-12)
    assert abs(independent.momentum(s)).max() < 1e-13 * np.sqrt(temperature) * 32
    assert edmd.Simulation(s).temperature == pytest.approx(temperature, rel=1e-12)
    assert independent.same_bits(s, edmd.thermalized(cold, seed=5, temperature=temperature))
    assert not independent.same_bits(s, edmd.thermalized(cold, seed=6, temperature=temperature))


def test_thermal_velocities_are_maxwellian():
    """Variance kT / m of every velocity component and kT / I about every body axis, kurtosis 3."""
    rng = np.random.default_rng(0)
    q = rng.normal(size=(4000, 4))
    s = edmd.System(rng.uniform(0, 100, (4000, 3)), q, (1, 1, 2), 100.0, masses=2.0)
    s = edmd.thermalized(s, seed=1, temperature=1.5)
    spin = independent.body_spin(s) * np.sqrt(independent.solid_moments(s.semi_axes, s.masses) / 1.5)
    for sample in (s.velocities * np.sqrt(2 / 1.5), spin):
        assert (sample**2).mean(axis=0) == pytest.approx(1, abs=4 * np.sqrt(2 / 4000))
        assert (sample**4).mean(axis=0) == pytest.approx(3, abs=4 * np.sqrt(96 / 4000))


@pytest.mark.parametrize("temperature", [0.0, -1.0, np.nan, np.inf, "hot"])
def test_bad_temperatures(temperature):
    with pytest.raises(ValueError, match=r"^temperature"):
        edmd.thermalized(fluids.fluid("sphere"), temperature=temperature)
