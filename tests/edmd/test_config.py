"""The config of a run: its text, its checks in words, its overrides."""

import copy
import json
import tomllib

import pytest

from edmd.config import DEFAULT, STAGES, SYSTEMS, config_text, read_config

SMALL = {"seed": 3, "system": {"kind": "random", "n": 32}, "stage": [{"kind": "run", "time": 1.0}]}


def test_the_text_with_every_default_is_the_default():
    assert read_config(tomllib.loads(config_text())) == read_config(DEFAULT)


def test_the_text_of_any_config_is_that_config():
    document = {"seed": 7, "system": {"kind": "random", "n": [20, 12], "semi_axes": [[1, 1, 2], [0.5, 0.5, 0.5]], "packing_fraction": 0.2},
                "stage": [{"kind": "run", "time": 2, "frames": {"time": 0.01, "per_decade": 5}},
                          {"kind": "compress", "until_pressure": 1e8}],
                "output": {"file": 'a "quoted" name.h5md', "log": False}}
    config = read_config(document)
    assert read_config(tomllib.loads(config_text(config))) == config
    assert read_config(json.loads(json.dumps(config.document()))) == config


def test_every_kind_of_start_is_in_the_text_and_can_be_uncommented():
    blocks = config_text().split("\n\n")
    for kind in SYSTEMS:
        block = next(block for block in blocks if "[system]" in block and f'kind = "{kind}"' in block)
        text = "\n".join(line.removeprefix("# ").removeprefix("or:  ") for line in block.splitlines())
        assert read_config(tomllib.loads(text) | {"stage": DEFAULT["stage"]}).system == SYSTEMS[kind]()
    assert all(f'kind = "{kind}"' in config_text() for kind in STAGES)


@pytest.mark.parametrize(("override", "words"), [
    ("sytem.n=3", ["sytem", "did you mean system?"]), ("system.pakcing_fraction=0.3", ["system.pakcing_fraction", "packing_fraction?"]),
    ("system.n=-3", ["system.n = -3", "whole number"]), ("system.n=many", ['system.n = "many"', "whole number"]),
    ("system.n=true", ["system.n = true"]), ("system.n=[]", ["system.n = []"]), ("system.n=[3, 0]", ["system.n[1] = 0"]),
    ("system.kind=randm", ['system.kind = "randm"', "did you mean random?"]), ("system.kind=lattice", ["system.n", "kind = \"lattice\""]),
    ("system.packing_fraction=1.2", ["system.packing_fraction = 1.2", "between 0 and 1"]),
    ("system.semi_axes=[1, 2]", ["system.semi_axes = [1, 2]", "three"]), ("system.semi_axes=[1, 2, nan]", ["system.semi_axes[2]"]),
    ("system=3", ["system = 3", "table"]), ("stage=3", ["stage"]), ("stage=[]", ["stage", "at least one"]), ("stage.0=3", ["stage.0 = 3"]),
    ("stage.0.kind=walk", ["stage.0.kind", "run", "compress"]), ("stage.0.collisions=3", ["stage.0", "exactly one of time"]),
    ("stage.1.time=3", ["stage.1.time=3", "from 0 to 0"]), ("stage.0.time=0", ["stage.0.time = 0"]), ("stage.0.time.x=0", ["stage.0.time"]),
    ("stage.0.time=inf", ["stage.0.time"]), ("output.frames={tim = 3}", ["output.frames.tim", "did you mean time?"]),
    ("output.frames={time = 3, collisions = 4}", ["output.frames", "exactly one"]), ("output.frames={}", ["output.frames", "exactly one"]),
    ("output.frames={time = 0}", ["output.frames", "time = 0"]), ("output.frames=3", ["output.frames = 3", "table"]),
    ("output.frames={time = 1, pressure_factor = 2}", ["output.frames.time"]), ("output.log=1", ["output.log = 1", "true, false"]),
    ("output.checkpoint=0", ["output.checkpoint"]), ("output.file=[]", ["output.file"]), ("seed=1.5", ["seed = 1.5"]),
    ("seed=-1", ["seed"]),
    ("seed", ["KEY=VALUE"]), ("=3", ["KEY=VALUE"]), ("a..b=3", ["KEY=VALUE"]), ("stage.0.frames={time = 'often'}", ["stage.0.frames"]),
])
def test_what_is_wrong_is_named_with_what_would_be_accepted(override, words):
    with pytest.raises(ValueError, match=r"expected|value") as problem:
        read_config(SMALL, [override])
    for word in words:
        assert word in str(problem.value)


def test_overrides():
    config = read_config(SMALL, ["seed=8", "system.n=[3, 4]", "stage.0.time=2.5", "output.file=other.h5md", "output.frames.time=0.5",
                                 "system.semi_axes=[[1,1,1],[2,2,2]]"])
    assert (config.seed, config.system.n, config.stages[0].time) == (8, (3, 4), 2.5)
    assert config.output.file == "other.h5md"
    assert config.output.frames == {"time": 0.5}
    assert config.system.semi_axes == ((1, 1, 1), (2, 2, 2))


def test_a_document_is_left_as_it_was():
    before = copy.deepcopy(SMALL)
    read_config(SMALL, ["stage.0.time=7", "output.log=false"])
    assert before == SMALL


@pytest.mark.parametrize("text", ["seed = ", "\x00", "[system", "seed = 1\nseed = 2"])
def test_a_file_that_is_not_toml(tmp_path, text):
    path = tmp_path / "run.toml"
    path.write_text(text)
    for wrong in (path, tmp_path / "missing.toml", tmp_path):
        with pytest.raises(ValueError, match=r"^config = "):
            read_config(wrong)
