import sys
from pathlib import Path

TESTS = Path(__file__).parents[1]
for folder in ("oracles", "edmd"):
    sys.path.insert(0, str(TESTS / folder))
