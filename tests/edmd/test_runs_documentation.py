"""The commands and snippets of docs/runs.md run as they stand, one after the other."""

import re
import shlex
from contextlib import redirect_stdout
from pathlib import Path

import pytest
from test_runs import datasets

import edmd
from edmd.cli import main
from edmd.trajectory import read_system

PAGE = (Path(__file__).parents[2] / "docs" / "runs.md").read_text()


def test_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for language, text in re.findall(r"```(\w*)\n(.*?)```", PAGE, re.DOTALL):
        if language == "toml":
            Path("run.toml").write_text(text)
        elif language == "python":
            exec(compile(text, "docs/runs.md", "exec"), {})
        elif "resume" in text:
            assert main(shlex.split(text)[1:]) == 2                 # the run it names is complete
            assert "nothing to resume" in capsys.readouterr().err
        else:
            for line in text.splitlines():
                command, _, output = line.partition(" > ")
                with open(output or "told", "w") as told, redirect_stdout(told):
                    assert main(shlex.split(command)[1:]) == 0
    assert edmd.read_config("all.toml").system.kind == "lattice"
    assert read_system("spheroids.h5md").packing_fraction == pytest.approx(0.4, abs=1e-14)
    assert read_system("dense.h5md").n == 64
    assert datasets("again.h5md") == datasets("dense.h5md")
    assert read_system("small.h5md").n == 32
