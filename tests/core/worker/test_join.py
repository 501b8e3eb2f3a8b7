"""When a stage fires: joins by capture time, watermark and deadline."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.core.worker.joined import MS, Bench, fire, tick

from followspot.transport.token import END
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput


def test_single_input_fires_for_every_message() -> None:
    bench = Bench(1)
    join = Join([JoinInput("in", joined=False, members=(bench.queues[0],))], lateness=0)
    bench.queues[0].put(tick(5, 1))
    bench.queues[0].put(tick(6, 2))
    assert [fire(join)[0].value, fire(join)[0].value] == [1, 2]  # type: ignore[index,union-attr,attr-defined]
    assert fire(join) is None


def test_join_waits_until_every_member_has_spoken() -> None:
    bench = Bench(2)
    join = bench.joined()
    bench.queues[0].put(tick(0))
    assert join.ready() is None
    bench.queues[1].put(tick(1 * MS))
    assert join.ready() == 0


def test_join_fires_without_a_member_that_settled_past_the_window() -> None:
    bench = Bench(2)
    join = bench.joined()
    bench.queues[0].put(tick(10 * MS))
    bench.queues[1].advance(14 * MS)
    assert join.ready() is None, "a message at 14 ms would still belong to the window"
    bench.queues[1].advance(14 * MS + 1)
    time = join.ready()
    assert time == 10 * MS
    assert len(join.take(time)[0][0]) == 1  # type: ignore[arg-type]


def test_join_goes_on_without_a_stream_that_ended() -> None:
    bench = Bench(2)
    join = bench.joined()
    bench.queues[1].advance(END)
    bench.queues[0].put(tick(7))
    assert join.ready() == 7
    join.take(7)
    bench.queues[0].advance(END)
    assert join.watermark() == END


@pytest.mark.parametrize("start", [0, 500 * MS])
def test_plain_input_without_its_partner_is_unmatched_not_fired(start: int) -> None:
    bench = Bench(2)
    join = bench.plain()
    bench.queues[0].put(tick(start))
    bench.queues[0].put(tick(start + 33 * MS))
    bench.queues[1].put(tick(start + 33 * MS))
    assert join.ready() == start + 33 * MS
    assert bench.ledger.count(0).unmatched == 1


def test_second_message_within_a_closed_window_is_unmatched() -> None:
    bench = Bench(2)
    join = bench.joined()
    for queue in bench.queues:
        queue.put(tick(0))
    bench.queues[0].put(tick(2 * MS))
    bench.queues[0].put(tick(33 * MS))
    assert fire(join) is not None
    assert join.ready() is None
    assert bench.ledger.count(0).unmatched == 1


def test_overdue_join_fires_with_what_is_there_and_counts_the_rest_as_late() -> None:
    bench = Bench(2)
    join = bench.joined()
    bench.queues[0].put(tick(0))
    assert join.ready() is None
    assert join.ready(overdue=True) == 0
    join.take(0)
    bench.queues[1].put(tick(1 * MS))
    bench.queues[1].put(tick(33 * MS))
    bench.queues[0].put(tick(33 * MS))
    assert join.ready() == 33 * MS
    assert bench.ledger.count(1).late == 1


@settings(deadline=None)
@given(
    times=st.lists(
        st.lists(st.integers(0, 40), unique=True, max_size=12).map(sorted), min_size=2, max_size=4
    ),
    seed=st.integers(0, 2**32 - 1),
)
def test_what_fires_together_does_not_depend_on_the_order_of_arrival(
    times: list[list[int]], seed: int
) -> None:
    """The same streams in two interleavings give the same firings: placement never changes the result."""
    assert _firings(times, random.Random(seed)) == _firings(times, random.Random(seed + 1))


def _firings(times: list[list[int]], order: random.Random) -> list[tuple[int, list[int]]]:
    bench = Bench(len(times))
    join = bench.joined(window=3)
    rest = [[tick(t, t) for t in stream] + [None] for stream in times]
    fired = []
    while any(rest):
        stream = order.choice([n for n, tokens in enumerate(rest) if tokens])
        token = rest[stream].pop(0)
        if token is None:
            bench.queues[stream].advance(END)
        else:
            bench.put(stream, token)
        while (time := join.ready()) is not None:
            arguments, messages = join.take(time)
            assert len(messages) == len(arguments[0])  # type: ignore[arg-type]
            fired.append((time, [m.value for m in messages]))  # type: ignore[attr-defined]
    counts = [bench.ledger.count(n) for n in range(len(times))]
    assert all(count.balanced for count in counts)
    assert sum(c.delivered + c.unmatched for c in counts) == sum(map(len, times))
    return fired
