"""The thin gas is trusted because its collisions are those of another oracle, and its contacts in equilibrium as many as they must be."""

from types import SimpleNamespace

import impacts
import numpy as np
import pytest
import reference
from scipy.spatial.transform import Rotation
from thin_gas import PLATES, PLATES_ERROR, PLATES_RATIO, ThinGas, cooling_ratios

PLATE, NEEDLE = (1, 1, 1 / 3), (1, 1, 3)


class Compared(ThinGas):
    """The first pairs of every batch collide in the reference too."""

    compared = 0

    def collide(self, one, other, place, restitution):
        pairs = [[one[k], other[k]] for k in range(min(len(one), 3))]
        before = [self.system(pair) for pair in pairs]
        super().collide(one, other, place, restitution)
        for pair, start, vector, e in zip(pairs, before, place, restitution):
            normal, levers = impacts.contact_of(start, 0, 1, vector)
            assert reference.pw(*self.shapes(start), vector)[0] == pytest.approx(1, abs=1e-11)
            impulse, loss = impacts.impulse_and_loss({"kind": "inelastic", "restitution": e}, impacts.surface_velocity(start, 0, 1, levers),
                                                     normal, impacts.effective(start, 0, 1, levers))
            velocities, spins = impacts.after(start, 0, 1, levers, impulse)
            end = self.system(pair)
            np.testing.assert_allclose(end.velocities, velocities, rtol=0, atol=1e-9)
            np.testing.assert_allclose(end.angular_velocities, spins, rtol=0, atol=1e-9)
            assert impacts.kinetic_energy(start) - impacts.kinetic_energy(end) == pytest.approx(loss, abs=1e-9)
            assert abs(end.velocities.sum(axis=0) - start.velocities.sum(axis=0)).max() < 1e-14
            self.compared += 1

    @staticmethod
    def shapes(system):
        return [reference.shape_matrix(axes, reference.quat_to_R(turn)) for axes, turn in zip(system.semi_axes, system.orientations)]

    def system(self, pair):
        turns = [Rotation.align_vectors(axis, [0, 0, 1])[0].as_quat(scalar_first=True) for axis in self.axis[pair]]
        squares = self.semi_axes**2
        return SimpleNamespace(semi_axes=np.tile(self.semi_axes, (2, 1)), orientations=np.array(turns), masses=np.ones(2),
                               moments=np.tile((squares.sum() - squares) / 5, (2, 1)),
                               velocities=self.velocity[pair], angular_velocities=self.spin[pair])


@pytest.mark.parametrize("semi_axes", [PLATE, NEEDLE])
def test_every_collision_is_one_of_the_reference(semi_axes):
    """Bodies really touch; momentum stays, and all energy but what restitution takes: none where the contact time makes it 1."""
    gas = Compared(semi_axes, 0.8, contact_time=0.05, bodies=600, ratio=1.0, seed=1)
    while gas.compared < 40:
        gas.step()
    assert abs((gas.spin * gas.axis).sum(axis=1)).max() < 1e-12
    np.testing.assert_allclose(gas.velocity.mean(axis=0), 0, atol=1e-14)


@pytest.mark.parametrize("semi_axes", [PLATE, NEEDLE])
def test_in_equilibrium_bodies_touch_as_often_as_they_must(semi_axes):
    """Contacts an encounter, repeated ones counted, against the exact rate at low density; and equipartition."""
    gas = ThinGas(semi_axes, 1.0, contact_time=0.0, bodies=6000, ratio=1.0, seed=2)
    shares, ratios = [], []
    for _ in range(15):
        encounters, contacts = gas.encounters, gas.contacts
        gas.step()
        shares.append((gas.contacts - contacts) / (gas.encounters - encounters))
        translation, rotation = gas.temperatures()
        ratios.append(rotation / translation)
    expected = reference.dilute(semi_axes, nph=1)["gamma"] / (4 * np.sqrt(np.pi) * gas.reach**2)       # over the rate of the spheres
    assert abs(np.mean(shares) - expected) < 4 * np.std(shares, ddof=1) / np.sqrt(len(shares))
    assert abs(np.mean(ratios) - 1) < 4 * np.sqrt(5 / (3 * 6000))        # of one look: they are hardly independent


@pytest.mark.validate
@pytest.mark.parametrize(("plates", "expected", "error"), [(PLATES | {"restitution": 1.0}, 1.0, 0.0), (PLATES, PLATES_RATIO, PLATES_ERROR)],
                         ids=["elastic", "inelastic"])
def test_ratio_of_plates(plates, expected, error):
    """Equipartition, and the number that the engine is held to: within three standard errors, by averages over blocks. Two minutes."""
    means = cooling_ratios(**plates, bodies=10_000, settling=25, blocks=16, contacts=10, seed=11)
    found = means.std(ddof=1) / np.sqrt(len(means))
    assert found < 0.004
    assert abs(means.mean() - expected) < 3 * np.hypot(found, error)
