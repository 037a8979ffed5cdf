"""Rules in configs and files: what is written, resumed, repeated and read (docs/granular.md)."""

import json
import re
import tomllib
from pathlib import Path

import h5py
import independent
import pytest
from test_runs import datasets

import edmd
from edmd.cli import main
from edmd.config import config_text, read_config
from edmd.rules.kinds import RULES

PAGE = (Path(__file__).parents[2] / "docs" / "granular.md").read_text()
ROUGH = {"kind": "rough", "restitution": 0.8, "tangential_restitution": 0.3, "contact_share": 0.01}
DOCUMENT = {"seed": 3, "system": {"kind": "random", "n": 40, "semi_axes": [1, 1, 2], "packing_fraction": 0.3}, "rule": ROUGH,
            "stage": [{"kind": "run", "collisions_per_particle": 20}, {"kind": "compress", "rate": 0.05, "until_packing_fraction": 0.35}]}


def test_the_rule_is_in_the_file_and_the_run_repeats_and_resumes(tmp_path, capsys):
    simulation = edmd.run(DOCUMENT, output=tmp_path / "whole.h5md")
    assert simulation.rule == edmd.Rough(0.8, 0.3, contact_share=0.01)
    with h5py.File(tmp_path / "whole.h5md") as file:
        own = dict(file["edmd"].attrs)
        temperatures, energies = (file[f"observables/{name}/value"][:] for name in ("temperature", "energy"))
    assert json.loads(own["rule"]) == simulation.rule.document()
    assert own["contact_time_collisions"] == simulation.contact_time_collisions
    assert temperatures[0] == pytest.approx(1, abs=1e-12)                   # all rotation counts from the start
    assert temperatures == pytest.approx(2 * energies / (6 * 40 - 3), rel=1e-12)

    def fail(view):
        if view.collisions > 250:
            raise RuntimeError("power cut")

    path = tmp_path / "cut.h5md"
    with pytest.raises(RuntimeError, match="power cut"):
        edmd.run(DOCUMENT | {"output": {"checkpoint": 1e-9}}, output=path, observers=[edmd.Observer(edmd.Every(collisions=50), fail)])
    assert independent.same_bits(edmd.resume(path).system, simulation.system)
    assert datasets(path) == datasets(tmp_path / "whole.h5md")
    assert main(["run", "--from", str(tmp_path / "whole.h5md"), "-o", str(tmp_path / "again.h5md"), "--quiet"]) == 0
    assert datasets(tmp_path / "again.h5md") == datasets(path)
    assert main(["info", str(path)]) == 0
    assert '"rough"' in capsys.readouterr().out


@pytest.mark.parametrize("kind", RULES)
def test_every_rule_is_in_the_text_of_a_config(kind):
    document = {"rule": {"kind": kind}, "stage": [{"kind": "run", "time": 1}]}
    config = read_config(document)
    assert config.rule == RULES[kind]()
    assert f'kind = "{kind}"' in config_text(document)
    assert read_config(config.document()) == config


@pytest.mark.parametrize(("override", "words"), [
    ("rule.kind=ruogh", ["rule.kind", "did you mean rough?"]), ("rule.restitution=1.5", ["rule.restitution = 1.5", "from 0 to 1"]),
    ("rule.tangential_restitution=-2", ["rule.tangential_restitution", "from -1 to 1"]), ("rule.contact_time=-1", ["rule.contact_time"]),
    ("rule.beta=0.3", ["rule.beta: no such key"]), ("rule.restitution=high", ["rule.restitution"]), ("rule=rough", ["rule"])])
def test_what_is_wrong_in_a_config_is_said(override, words):
    with pytest.raises(ValueError, match="expected") as problem:
        read_config(DOCUMENT, [override])
    for word in words:
        assert word in str(problem.value)


@pytest.mark.parametrize(("rule", "smooth"), [({"kind": "inelastic"}, True), (ROUGH, False)])
def test_only_rough_bodies_start_with_spin_about_their_axes(rule, smooth, tmp_path):
    first = []
    edmd.run(DOCUMENT | {"rule": rule, "stage": [{"kind": "run", "time": 0.1}]}, output=tmp_path / "run.h5md",
             observers=[edmd.Observer(edmd.Every(time=0.01), lambda view: first.append(view.system))])
    assert (abs(independent.body_spin(first[0])[:, 2]).max() < 1e-12) == smooth


def test_a_run_that_collapses_leaves_its_state_beside_the_file(tmp_path, capsys):
    run = tmp_path / "run.toml"
    run.write_text('[system]\nkind = "random"\nn = 64\nsemi_axes = [1, 1, 3]\npacking_fraction = 0.2\n[rule]\nkind = "inelastic"\n'
                   'restitution = 0.3\n[[stage]]\nkind = "run"\ncollisions_per_particle = 200\n')
    assert main(["run", str(run), "-o", str(tmp_path / "run.h5md"), "--quiet"]) == 1
    assert "Inelastic collapse" in capsys.readouterr().err
    assert edmd.Simulation.load(tmp_path / "run.stalled.npz").rule == edmd.Inelastic(0.3)


def test_the_config_of_the_page_is_one():
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    assert read_config(DOCUMENT | {"rule": tomllib.loads(text)["rule"]}).rule == edmd.Rough(0.9, 0.2, 0.0, 3e-3)
