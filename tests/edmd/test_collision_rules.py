"""Each rule, one collision at a time, against plain numpy: what the bodies do, what is conserved, what is lost."""

import granular
import impacts
import numpy as np
import pytest
from cross_section import some_of

import edmd
from edmd.rules.kinds import RULES, RuleKind, chosen_rule

SEEDS = range(6)


def collision(axes, rule, seed):
    """-> the state just before the first collision, the state at it with the velocities after, and the vector from one to the other."""
    start = granular.about_to_collide(axes, seed)
    simulation = edmd.Simulation(start, rule=rule).run(collisions=1)
    before = edmd.Simulation(start, rule=rule).run(time=simulation.time * (1 - 1e-13)).system
    return before, simulation, before.positions[1] - before.positions[0]


@pytest.mark.parametrize("seeds", some_of([SEEDS[:2], SEEDS[2:]], [SEEDS[:2]]), ids=str)
@pytest.mark.parametrize("pair", granular.PAIRS)
@pytest.mark.parametrize("name", granular.RULES)
def test_collision(name, pair, seeds):
    rule = granular.RULES[name]
    document = rule.document()
    for seed in seeds:
        before, simulation, vector = collision(granular.PAIRS[pair], rule, seed)
        system = simulation.system
        n, levers = impacts.contact_of(before, 0, 1, vector)
        matrix, velocity = impacts.effective(before, 0, 1, levers), impacts.surface_velocity(before, 0, 1, levers)
        impulse, loss = impacts.impulse_and_loss(document, velocity, n, matrix)
        v, w = impacts.after(before, 0, 1, levers, impulse)
        exact = 1e-9
        assert system.velocities == pytest.approx(v, abs=exact)
        assert system.angular_velocities == pytest.approx(w, abs=30 * exact)

        lost = impacts.kinetic_energy(before) - impacts.kinetic_energy(system)
        assert lost == pytest.approx(loss, abs=10 * exact)
        assert lost >= -1e-12
        simulation.verify()

        assert before.masses @ system.velocities == pytest.approx(before.masses @ before.velocities, abs=1e-13)
        for k, lever in enumerate(levers):                              # about the contact point each body keeps its own
            inverse = impacts.inverse_inertia(before, k)
            first, last = (np.linalg.solve(inverse, state.angular_velocities[k]) - np.cross(lever, state.masses[k] * state.velocities[k])
                           for state in (before, system))
            assert last == pytest.approx(first, abs=1e-9)

        left = impacts.surface_velocity(system, 0, 1, levers)
        e = impacts.normal_restitution(document, -velocity @ n)
        assert left @ n == pytest.approx(-e * (velocity @ n), abs=exact)
        if document["kind"] == "rough" and pair == "spheres":
            tangential = velocity - (velocity @ n) * n
            assert left - (left @ n) * n == pytest.approx(-document["tangential_restitution"] * tangential, abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_perfectly_rough_bodies_reverse_the_velocity_of_the_contact(seed):
    before, simulation, vector = collision(granular.PAIRS["needle and plate"], edmd.Rough(1.0, 1.0), seed)
    _, levers = impacts.contact_of(before, 0, 1, vector)
    first, last = (impacts.surface_velocity(state, 0, 1, levers) for state in (before, simulation.system))
    assert last == pytest.approx(-first, abs=1e-9)


def test_reversing_the_tangential_velocity_of_any_bodies_would_create_energy():
    """Why eq. (29) is not that: e = 1, beta = -1 must be smooth and lossless, and the plain reversal is not."""
    gained = []
    for seed in range(40):
        before, _, vector = collision(granular.PAIRS["prolate and oblate"], edmd.Elastic(), seed)
        n, levers = impacts.contact_of(before, 0, 1, vector)
        matrix, velocity = impacts.effective(before, 0, 1, levers), impacts.surface_velocity(before, 0, 1, levers)
        wanted = velocity - 2 * (velocity @ n) * n
        gained.append(0.5 * (wanted @ np.linalg.solve(matrix, wanted) - velocity @ np.linalg.solve(matrix, velocity)))
    assert max(gained) > 0.1


@pytest.mark.parametrize(("d", "error"), [(0.0, 1e-15), (0.01, 1e-7), (0.1, 6e-5), (0.3, 8e-4), (1.0, 6e-3), (2.0, 1e-2)])
def test_viscoelastic_restitution_is_that_of_the_equation_of_motion(d, error):
    """From e = 1 down to 0.2: the published approximant is as good as this."""
    from edmd.rules.viscoelastic import restitution

    assert restitution(1.0, np.array([d])) == pytest.approx(impacts.viscoelastic_restitution(d) if d else 1.0, abs=error)
    assert restitution(32.0, np.array([d])) == pytest.approx(restitution(1.0, np.array([2 * d])), abs=1e-12)


# what is accepted

def test_restitution_alone_chooses_the_rule():
    assert chosen_rule() == edmd.Elastic()
    assert chosen_rule(0.9) == edmd.Inelastic(0.9)
    assert chosen_rule(0.9, "rough") == edmd.Rough(0.9)
    assert chosen_rule(rule=edmd.PowerLaw()) == edmd.PowerLaw()


@pytest.mark.parametrize(("make", "words"), [
    (lambda s: edmd.Simulation(s, restitution=1.1), r"restitution = 1\.1.*from 0 to 1"),
    (lambda s: edmd.Simulation(s, restitution=-0.1), r"restitution = -0\.1"),
    (lambda s: edmd.Simulation(s, restitution=np.nan), "restitution = nan"),
    (lambda s: edmd.Simulation(s, restitution="soft"), "restitution = 'soft'"),
    (lambda s: edmd.Simulation(s, rule="inelastik"), r"rule = 'inelastik'.*did you mean 'inelastic'"),
    (lambda s: edmd.Simulation(s, rule=3), r"rule = 3: expected"),
    (lambda s: edmd.Simulation(s, 0, 0.9, edmd.Rough(0.8)), r"restitution = 0\.9 and rule"),
    (lambda s: edmd.Simulation(s, 0, 0.9, "elastic"), "restitution"),
    (lambda s: edmd.Rough(tangential_restitution=1.5), r"tangential_restitution = 1\.5.*from -1 to 1"),
    (lambda s: edmd.Rough(tangential_restitution=-1.5), r"tangential_restitution = -1\.5"),
    (lambda s: edmd.Inelastic(0.9, contact_time=-1e-3), r"contact_time = -0\.001.*0 or more"),
    (lambda s: edmd.Inelastic(0.9, contact_share=-1.0), r"contact_share = -1"),
    (lambda s: edmd.Inelastic("0.9"), "restitution = '0.9'"), (lambda s: edmd.Inelastic(True), "restitution = True"),
    (lambda s: edmd.Viscoelastic(-0.1), r"dissipation = -0\.1"), (lambda s: edmd.PowerLaw(velocity=0), r"velocity = 0"),
    (lambda s: edmd.PowerLaw(exponent=0), r"exponent = 0"),
    (lambda s: edmd.thermalized(s, spin="some"), r"spin = 'some'.*drawn"),
])
def test_what_is_wrong_is_said(make, words):
    with pytest.raises(ValueError, match=words):
        make(granular.about_to_collide(granular.PAIRS["spheres"], 1))


@pytest.mark.parametrize("kind", RuleKind)
def test_every_kind_has_its_record_and_comes_back_from_its_document(kind):
    from edmd.rules.kinds import KIND, RECORDS, rule_of, rule_row

    record = RECORDS[kind]
    assert RULES[record.kind] is record
    assert getattr(edmd, record.__name__) is record
    assert any(type(rule) is record for rule in granular.RULES.values()), "a rule without a test"
    assert rule_of(record().document()) == record()
    assert rule_row(record())[KIND] == kind
