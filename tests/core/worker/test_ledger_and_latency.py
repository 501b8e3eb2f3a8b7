"""The ledger adds up; latency quantiles are right to the width of a bin."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot.worker.latency import LatencyHistogram
from followspot.worker.ledger import (
    AWAY,
    COLUMNS,
    DELIVERED,
    DROPPED,
    INVALID,
    LATE,
    LOST,
    OVERRUN,
    PRODUCED,
    REFUSED,
    SHED,
    UNMATCHED,
    Ledger,
    tally,
)

READERS = (DELIVERED, DROPPED, LATE, UNMATCHED, INVALID)
SENDERS = (SHED, OVERRUN, REFUSED, AWAY)


def test_what_is_not_accounted_for_is_in_flight() -> None:
    ledger = Ledger(2)
    for column, count in {PRODUCED: 14, AWAY: 4, DELIVERED: 5, LATE: 1, SHED: 2, REFUSED: 1}.items():
        ledger.words[ledger.row(1) + column] = count
    count = ledger.count(1)
    assert (count.produced, count.away, count.sent, count.delivered, count.late) == (14, 4, 10, 5, 1)
    assert (count.dropped, count.invalid, count.in_flight, count.surplus) == (2, 1, 1, 0)
    assert not count.balanced
    assert ledger.count(0).balanced


@settings(deadline=None)
@given(st.lists(st.integers(0, 1000), min_size=COLUMNS, max_size=COLUMNS))
def test_columns_always_add_up_and_none_is_negative(row: list[int]) -> None:
    """Whatever the words are, as those of several hosts are not of one moment."""
    c = tally(row)
    assert c.produced == c.sent + c.away
    assert c.sent == c.delivered + c.dropped + c.late + c.unmatched + c.invalid + c.lost + c.in_flight
    assert c.lost <= row[LOST]
    assert min(vars(c).values()) >= 0
    assert c.surplus == max(0, sum(row[n] for n in (*READERS, *SENDERS)) - row[PRODUCED])


def test_more_accounted_for_than_sent_is_no_balance() -> None:
    row = [0] * COLUMNS
    row[PRODUCED], row[DELIVERED] = 3, 4
    count = tally(row)
    assert (count.produced, count.sent, count.in_flight, count.surplus) == (4, 4, 0, 1)
    assert not count.balanced
    assert not count.with_lost(10).balanced


class Counting:
    """Words that somebody else counts in while they are read: one more message is through at every word."""

    def __init__(self) -> None:
        self.words = [0] * COLUMNS

    def read(self) -> list[int]:
        found = []
        for column in range(COLUMNS):
            for counted in (PRODUCED, DELIVERED, PRODUCED, SHED, PRODUCED, AWAY):
                self.words[counted] += 1
            found.append(self.words[column])
        return found


def test_a_row_that_is_read_while_both_ends_count_never_accounts_for_more_than_was_sent() -> None:
    counting = Counting()
    for _ in range(3):
        count = tally(counting.read())
        assert count.surplus == 0
        assert count.in_flight > 0


@settings(deadline=None)
@given(st.lists(st.integers(1, 10**10), min_size=1, max_size=200), st.sampled_from([0.5, 0.95, 0.99]))
def test_quantiles_are_within_two_percent(values: list[int], share: float) -> None:
    histogram = LatencyHistogram()
    for number, value in enumerate(values):
        histogram.add(value, "camera", number)
    exact = float(np.quantile(values, share, method="inverted_cdf")) / 1e6
    assert abs(histogram.quantile(share) - exact) <= 0.02 * exact + 1e-6
    summary = histogram.summary("camera", "save")
    assert summary.worst_ms == max(values) / 1e6
    shares = {0.5: summary.p50_ms, 0.95: summary.p95_ms, 0.99: summary.p99_ms}
    assert shares[share] == histogram.quantile(share)
    assert summary.worst_id == f"camera#{values.index(max(values))}"
