"""The calendar against a plain minimum over all bodies: the earliest event first, of equal times that of the first body."""

import numpy as np
import pytest

from edmd.building import _calendar
from edmd.calendar import schedule


@pytest.mark.parametrize("n", [1, 2, 7, 8, 9, 64, 65, 500, 513, 4097])
def test_the_earliest_event_comes_first(n):
    rng = np.random.default_rng(n)
    calendar, times = _calendar(n), np.full(n, np.inf)
    for _ in range(3000):
        body, time = int(rng.integers(n)), float(rng.choice([rng.integers(0, 40), rng.uniform(0, 40), np.inf]))
        times[body] = time
        schedule(calendar, body, time)
        assert calendar.time[0] == times.min()
        assert calendar.body[0] == times.argmin()
