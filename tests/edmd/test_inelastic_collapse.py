"""Inelastic collapse: told where it happens, with the bodies and a file; the TC model avoids it, and says how often."""

import granular
import numpy as np
import pytest

import edmd

STARTS = [((0, 3, 6.7), (1, 0, -0.8)), ((0, 1, 3), (0, 0, -1))]


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def exact_collisions(e, positions, velocities, digits=80):
    """Collisions of three balls on a line, by mpmath."""
    from mpmath import mp, mpf

    with mp.workdps(digits):
        x, v, e = [mpf(str(a)) for a in positions], [mpf(str(a)) for a in velocities], mpf(str(e))
        for count in range(1000):
            approaching = [((x[i + 1] - x[i] - 1) / (v[i] - v[i + 1]), i) for i in (0, 1) if v[i] > v[i + 1]]
            if not approaching:
                return count
            time, i = min(approaching)
            x = [a + b * time for a, b in zip(x, v)]
            mean, half = (v[i] + v[i + 1]) / 2, (v[i] - v[i + 1]) / 2
            v[i], v[i + 1] = mean - e * half, mean + e * half
    return np.inf


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("e", [0.08, 0.075, 0.073])
def test_three_balls_above_the_critical_restitution_separate(e, start):
    """7 - 4 sqrt(3) = 0.0718 (McNamara and Young, Phys. Fluids A 4, 496 (1992)): 26 collisions at 0.073 before they part."""
    simulation = granular.line(*start, edmd.Inelastic(e)).run(time=15.0)
    assert simulation.collisions == exact_collisions(e, *start)
    assert (simulation.collisions == 26) == (e == 0.073)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("e", [0.07, 0.05, 0.0])
def test_three_balls_below_it_collapse_and_it_is_said(e, start):
    simulation = granular.line(*start, edmd.Inelastic(e))
    with pytest.raises(edmd.Stalled, match=r"time stands still.*: 0, 1, 2\. Inelastic collapse.*contact_share") as stalled:
        simulation.run(time=15.0)
    assert stalled.value.bodies == (0, 1, 2)
    assert 30 < simulation.collisions < 80
    loaded = edmd.Simulation.load(stalled.value.path)
    assert loaded.collisions == simulation.collisions
    assert loaded.rule == edmd.Inelastic(e)
    with pytest.raises(edmd.Stalled):
        loaded.run(time=15.0)
    freed = edmd.Simulation(loaded.system, rule=edmd.Inelastic(e, contact_time=1e-3)).run(time=1.0)
    assert freed.time == pytest.approx(1.0)


@pytest.mark.parametrize("e", [0.07, 0.0])
def test_the_contact_time_avoids_it(e):
    simulation = granular.line(*STARTS[0], edmd.Inelastic(e, contact_time=1e-3)).run(time=15.0)
    assert 0 < simulation.contact_time_collisions < simulation.collisions < 20
    simulation.verify()


def test_a_pair_of_ellipsoids_that_presses_together_is_found():
    """Turning bodies are driven together like a ball by gravity: two are enough for infinitely many collisions in finite time."""
    start = edmd.thermalized(edmd.random_system(64, (1, 1, 3), 0.2, seed=1), 1, spin="none")
    simulation = edmd.Simulation(start, rule=edmd.Inelastic(0.3))
    with pytest.raises(edmd.Stalled, match="Inelastic collapse") as stalled:
        simulation.run(collisions_per_particle=100)
    assert len(stalled.value.bodies) == 2
    simulation = edmd.Simulation(start, rule=edmd.Inelastic(0.3, contact_share=3e-3)).run(collisions_per_particle=100)
    assert simulation.contact_time_collisions > 0
    simulation.verify()


def a_plate_on_a_ball(gap, box, rule):
    """It lies flat on the ball and begins to turn: no gap, no rate, and its edge comes."""
    system = edmd.System([[1, 1, 1], [1, 1, (1 / 3 + 0.5) * (1 + gap) + 1]], [[1, 0, 0, 0]] * 2, [[1, 1, 1 / 3], [0.5, 0.5, 0.5]], box,
                         velocities=np.zeros((2, 3)), angular_velocities=[[1, 0, 0], [0, 0, 0]])
    return edmd.Simulation(system, rule=rule)


@pytest.mark.parametrize("rule", [edmd.Elastic(), edmd.Inelastic(0.8, contact_share=1e-3)], ids=["elastic", "inelastic"])
@pytest.mark.parametrize(("gap", "box"), [(-1e-15, 10.0), (0.0, 10.0), (1e-15, 100.0), (1e-14, 6.0), (1e-12, 1000.0)])
def test_bodies_that_turn_into_each_other_from_rest_go_on_until_they_part(gap, box, rule):
    """They bounce as low as a gap is known, until the plate has slid off at a time of 1.3: time must not stand still, nor they sink in."""
    simulation = a_plate_on_a_ball(gap, box, rule)
    energy = simulation.energy
    for _ in range(6):
        simulation.run(time=0.25)
        simulation.verify()
    bounces = simulation.collisions
    assert 100_000 < bounces < 2_000_000
    assert simulation.energy == pytest.approx(energy, rel=1e-9)
    simulation.run(time=0.5)
    assert simulation.collisions == bounces


def test_bodies_that_turn_into_each_other_collapse_where_each_collision_takes_energy():
    with pytest.raises(edmd.Stalled, match="Inelastic collapse"):
        a_plate_on_a_ball(0.0, 10.0, edmd.Inelastic(0.8)).run(time=1.0)


def test_bodies_at_rest_are_told_when_collisions_are_waited_for():
    simulation = granular.line((0, 3), (1, -1), edmd.Inelastic(0.0))
    with pytest.raises(edmd.Stalled, match=r"after 1 collisions.*at rest"):
        simulation.run(collisions=5)
    simulation.run(time=3.0)
    assert simulation.time == pytest.approx(4.0)


def test_a_folder_that_cannot_be_written_does_not_hide_the_collapse():
    simulation = granular.line(*STARTS[0], edmd.Inelastic(0.05))
    simulation.stall_path = "no/such/folder/state.npz"
    with pytest.raises(edmd.Stalled, match="Inelastic collapse") as stalled:
        simulation.run(time=15.0)
    assert stalled.value.path is None


def test_a_collision_is_spared_when_either_partner_has_just_collided():
    """Which collisions lose energy, by a list of everybody's last collision, kept outside the engine."""
    contact_time, n = 0.05, 48
    simulation = edmd.Simulation(edmd.random_system(n, (0.5, 0.5, 0.5), 0.3, seed=3), rule=edmd.Inelastic(0.7, contact_time=contact_time))
    last, spared, before = np.full(n, -np.inf), [], [simulation.system.velocities, simulation.energy]

    def look(view):
        velocities, energy = view.system.velocities, view.energy
        pair = np.flatnonzero(abs(velocities - before[0]).max(axis=1) > 0)
        assert len(pair) == 2
        soon = view.time - last[pair].max() < contact_time
        assert (energy > before[1] * (1 - 1e-13)) == soon
        last[pair], before[:] = view.time, (velocities, energy)
        spared.append(soon)

    simulation.run(collisions=600, observers=[edmd.Observer(edmd.Every(collisions=1), look)])
    assert simulation.contact_time_collisions == sum(spared)
    assert 100 < sum(spared) < 500
