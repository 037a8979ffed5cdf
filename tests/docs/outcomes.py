"""What should have come about when a page was followed: numbers that it states, files that agree. `names` are those of its Python."""

from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from test_runs import datasets

import edmd


def analysis(names):
    assert names["phi_J"] == pytest.approx(np.pi / np.sqrt(18), abs=2e-5)
    assert names["f"] == pytest.approx(2.97, abs=0.05)
    assert np.allclose(names["displaced"].results.lag, 0.25 * np.arange(21))
    ballistic = names["displaced"].results.total[1] / 0.25**2
    assert 1 < ballistic < 3                                                        # 3 kT / m until the first collisions
    assert 0.005 < names["error"] < 0.2                                             # of twelve seeds: 0.018 to 0.050
    assert names["pressure"] == pytest.approx(7.96, abs=0.04 + 4 * names["error"])  # docs/validation.md: 1:1:2 at 0.40, with its own error
    assert Path("g.png").stat().st_size > 5000
    assert Path("displacement.png").stat().st_size > 5000


def runs(names):
    assert edmd.read_config("all.toml").system.kind == "lattice"
    assert edmd.read_system("spheroids.h5md").packing_fraction == pytest.approx(0.4, abs=1e-14)
    assert edmd.read_system("dense.h5md").n == 64
    assert datasets("again.h5md") == datasets("dense.h5md")
    assert edmd.read_system("small.h5md").n == 32


def sweeps(names):
    table = pyarrow.parquet.read_table("rates/table.parquet").to_pydict()
    assert table["replica"] == [0, 1] * 2
    dense = {rate: [phi for phi, one in zip(table["packing_fraction"], table["stage.0.rate"]) if one == rate] for rate in (0.5, 0.1)}
    assert sum(dense[0.1]) > sum(dense[0.5])
    assert pyarrow.parquet.read_table("melting/table.parquet").num_rows == 2
    assert pyarrow.parquet.read_table("fluid/table.parquet").num_rows == 2
    assert Path("melting.png").exists()


def file_format(names):
    assert datasets("run.h5md")
    assert len(edmd.read_system("run.xyz").positions) == edmd.read_system("last.data").n == names["system"].n


def tutorial(names):
    assert edmd.read_system("first.h5md").packing_fraction == pytest.approx(0.71, abs=0.015)
    assert names["phi_J"] == pytest.approx(edmd.read_system("first.h5md").packing_fraction, abs=2e-3)
    assert Path("contacts.png").stat().st_size > 5000


def packing(names):
    assert edmd.read_system("mixture.h5md").species.tolist() == [0] * 40 + [1] * 60
    assert names["plateau"] == pytest.approx(names["packing"].mean_contact_number, abs=0.5)
