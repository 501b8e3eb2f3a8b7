"""The ledger adds up; latency quantiles are right to the width of a bin."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot.runtime.latency import LatencyHistogram
from followspot.runtime.ledger import COLUMNS, DELIVERED, LATE, SENT, SHED, Ledger, tally


def test_what_is_not_accounted_for_is_in_flight() -> None:
    ledger = Ledger(2)
    ledger.words[ledger.row(1) + SENT] = 10
    ledger.words[ledger.row(1) + DELIVERED] = 6
    ledger.words[ledger.row(1) + LATE] = 1
    ledger.words[ledger.row(1) + SHED] = 2
    count = ledger.count(1)
    assert (count.sent, count.delivered, count.late, count.dropped, count.in_flight) == (10, 6, 1, 2, 1)
    assert not count.balanced
    assert ledger.count(0).balanced


@settings(deadline=None)
@given(st.lists(st.integers(0, 1000), min_size=COLUMNS, max_size=COLUMNS))
def test_sent_is_always_the_sum_of_the_rest(row: list[int]) -> None:
    c = tally(row)
    assert c.sent == c.delivered + c.dropped + c.late + c.unmatched + c.invalid + c.in_flight


@settings(deadline=None)
@given(st.lists(st.integers(1, 10**10), min_size=1, max_size=200), st.sampled_from([0.5, 0.95]))
def test_quantiles_are_within_two_percent(values: list[int], share: float) -> None:
    histogram = LatencyHistogram()
    for number, value in enumerate(values):
        histogram.add(value, "camera", number)
    exact = float(np.quantile(values, share, method="inverted_cdf")) / 1e6
    assert abs(histogram.quantile(share) - exact) <= 0.02 * exact + 1e-6
    summary = histogram.summary("camera", "save")
    assert summary.worst_ms == max(values) / 1e6
    assert summary.worst_id == f"camera#{values.index(max(values))}"
