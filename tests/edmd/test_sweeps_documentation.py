"""docs/sweeps.md names every key and file of a sweep, and its SLURM job is one that dask-jobqueue takes (tests/docs runs the rest)."""

import re
import tomllib
from pathlib import Path

import pytest

from edmd.sweeps.file import SweepFile
from edmd.sweeps.pools import slurm_cluster

PAGE = (Path(__file__).parents[2] / "docs" / "sweeps.md").read_text()


def test_the_slurm_options_of_the_page_make_a_job():
    (slurm,) = [tomllib.loads(text)["slurm"] for text in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "[slurm]" in text]
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
