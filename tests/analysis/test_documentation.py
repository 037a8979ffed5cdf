"""The snippets of docs/analysis.md run as they stand, one after the other."""

import re
from pathlib import Path

import numpy as np
import pytest

import analysis

PAGE = (Path(__file__).parents[2] / "docs" / "analysis.md").read_text()


def test_the_snippets_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for snippet in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(compile(snippet, "docs/analysis.md", "exec"), names)
    assert names["phi_J"] == pytest.approx(np.pi / np.sqrt(18), abs=2e-5)         # what the page says they print
    assert names["f"] == pytest.approx(2.97, abs=0.05)
    assert np.allclose(names["displaced"].results.lag, 0.25 * np.arange(21))
    ballistic = names["displaced"].results.total[1] / 0.25**2
    assert 1 < ballistic < 3                                                        # 3 kT / m until the first collisions
    assert names["pressure"] == pytest.approx(7.96, abs=4 * names["error"])         # docs/validation.md: 1:1:2 at 0.40
    assert 0.002 < names["error"] < 0.05
    assert (tmp_path / "g.png").stat().st_size > 5000


def test_every_name_of_the_page_is_there():
    table = PAGE.split("## Observables")[1].split("###")[0]
    words = {word for cell in re.findall(r"`([^`]+)`", table) for word in re.findall(r"[A-Za-z_]\w+", cell)}
    known = {word for word in words if word in analysis.__all__}
    assert len(known) > 25
    functions = {name for name in analysis.__all__ if name[0].isupper() and not name.startswith("EDMD")}
    assert functions <= known, f"not on the page: {functions - known}"
