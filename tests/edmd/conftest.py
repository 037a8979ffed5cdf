import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
for folder in ("oracles", "edmd"):
    sys.path.insert(0, str(TESTS / folder))


@pytest.fixture
def no_summary(monkeypatch):
    """Sweeps that draw nothing, where nobody looks: what they may have to draw is in test_sweep_summary.py."""
    monkeypatch.setattr("edmd.sweeps.campaign.draw_summary", lambda *arguments, **options: [])
