"""The files and commands of docs/sweeps.md run as they stand, one after the other; those for clusters are tried in test_sweep_clusters."""

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pyarrow.parquet
import pytest
from test_sweeps import HERE

from edmd.cli import main
from edmd.sweeps.file import SweepFile
from edmd.sweeps.pools import slurm_cluster

PAGE = (Path(__file__).parents[2] / "docs" / "sweeps.md").read_text()


def test_the_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```(\w*)\n(.*?)```", PAGE, re.DOTALL)
    (slurm,) = [tomllib.loads(text)["slurm"] for language, text in blocks if "[slurm]" in text]
    for language, text in blocks:
        if language == "toml" and "[slurm]" not in text:
            Path("sweep.toml").write_text(text)
        elif language == "python":
            Path("melting.py").write_text(text)
            subprocess.run([sys.executable, "melting.py"], check=True, env=HERE | {"MPLBACKEND": "agg"})
        elif language == "":
            assert main(shlex.split(text)[1:]) == 0
    table = pyarrow.parquet.read_table("rates/table.parquet").to_pydict()
    assert table["replica"] == [0, 1] * 3
    dense = {rate: [phi for phi, one in zip(table["packing_fraction"], table["stage.0.rate"]) if one == rate] for rate in (0.5, 0.1)}
    assert sum(dense[0.1]) > sum(dense[0.5])
    assert pyarrow.parquet.read_table("melting/table.parquet").num_rows == 2
    assert pyarrow.parquet.read_table("fluid/table.parquet").num_rows == 2
    assert Path("melting.png").exists()
    with slurm_cluster(slurm | {"interface": "lo"}) as cluster:
        script = cluster.job_script()
    for words in ("--lifetime 42900s", "#SBATCH -p long", "#SBATCH -A granular", "#SBATCH -t 12:00:00", "activate"):
        assert words in script


@pytest.mark.parametrize("name", SweepFile.__dataclass_fields__)
def test_every_key_is_on_the_page(name):
    assert re.search(rf"`(\[\[?)?{name}(\]\]?)?`", PAGE)


def test_every_file_that_a_sweep_leaves_is_on_the_page():
    from edmd.sweeps import account, figure, ownership, pools, results, table

    for name in (account.LOG, figure.FIGURE, ownership.MANIFEST, pools.OUTPUT, results.RESULT, table.CSV, table.PARQUET):
        assert f"`{name}`" in PAGE
