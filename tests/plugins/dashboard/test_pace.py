"""How far ahead a previewed capture time is chosen."""

from __future__ import annotations

import pytest

from followspot_dashboard.gate import MAX_LEAD
from followspot_dashboard.pace import Pace

MS = 1_000_000


@pytest.mark.parametrize(("frames", "lead"), [(2, 1.5), (4, 3.5), (60, MAX_LEAD - 0.5)])
def test_the_lead_is_what_the_graph_processes_in_a_period_and_no_more_than_it_has_in_flight(
    frames: int, lead: float
) -> None:
    pace = Pace()
    for number in range(1, frames + 1):
        pace.add(number * 10 * MS)
    assert pace.ahead(now=1000 * MS, period=1000 * MS) == lead * 10 * MS
