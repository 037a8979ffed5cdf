"""Where a file comes from: version, parameters, seed, platform."""

import json
import platform
from datetime import UTC, datetime

import numpy as np

import edmd


def provenance(parameters, seed, start=None):
    """Attributes that tell how a run was made; parameters: what JSON can hold; start: a digest of the first state, for runs of a config."""
    import numba

    return {"version": edmd.__version__, "parameters": json.dumps(parameters, default=_plain), "seed": int(seed),
            "platform": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}, "
                        f"numba {numba.__version__}",
            "created": datetime.now(UTC).isoformat(timespec="seconds"), **({} if start is None else {"start": start})}


def _plain(value):
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)
