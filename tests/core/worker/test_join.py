"""When a stage fires: joins by capture time and watermark, sampled inputs, deadlines."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot.messages import Header, Message, stamped
from followspot.transport.token import END, Watermark
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.inputs.sampled_input import NearestInput, NewestInput, SampledInput, WindowInput
from followspot.worker.ledger import PRODUCED, Ledger

MS = 1_000_000


class Tick(Message):
    """A number, to be told apart."""

    value: int


def tick(time: int, value: int = 0) -> Tick:
    return stamped(Tick(value), Header("test", value, time))


class Bench:
    """Some input queues with a ledger of their own."""

    def __init__(self, edges: int, *, lateness: int = 0) -> None:
        self.ledger = Ledger(edges)
        self.queues = [
            InputQueue(f"edge{n}", self.ledger.words, self.ledger.row(n), depth=100, lateness=lateness)
            for n in range(edges)
        ]

    def put(self, edge: int, message: Message) -> None:
        """As an output port of the same worker does."""
        self.ledger.words[self.ledger.row(edge) + PRODUCED] += 1
        self.queues[edge].put(message)

    def joined(self, window: int = 4 * MS, lateness: int | None = None) -> Join:
        port = JoinInput("all", joined=True, members=tuple(self.queues))
        self._let_differ(window)
        return Join([port], lateness=window if lateness is None else lateness)

    def plain(self, window: int = 4 * MS) -> Join:
        ports = [JoinInput(f"in{n}", joined=False, members=(queue,)) for n, queue in enumerate(self.queues)]
        self._let_differ(window)
        return Join(ports, lateness=window)

    def _let_differ(self, window: int) -> None:
        for queue in self.queues:
            queue.window = window


def fire(join: Join) -> list[object] | None:
    time = join.ready()
    return None if time is None else join.take(time)[0]


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


@pytest.mark.parametrize("delay", [1, 2, 3])
def test_delayed_input_is_the_message_of_exactly_n_firings_ago(delay: int) -> None:
    bench = Bench(2)
    empty = Tick.empty()
    sampled = NewestInput(bench.queues[1], delay=delay, timed=True, initial=empty)
    main = JoinInput("in", joined=False, members=(bench.queues[0],))
    join = Join([main, JoinInput("back", joined=False, sampled=sampled)], lateness=0)
    for n in range(8):
        bench.queues[0].put(tick(n * 10, n))
        time = join.ready()
        assert time == n * 10
        back = join.take(time)[0][1]
        assert back is empty if n < delay else back.value == n - delay  # type: ignore[attr-defined]
        bench.queues[1].put(tick(n * 10, n))


def test_delayed_input_waits_for_the_answer_to_the_firing_before() -> None:
    bench = Bench(2)
    sampled = NewestInput(bench.queues[1], delay=1, timed=True, initial=Tick.empty())
    main = JoinInput("in", joined=False, members=(bench.queues[0],))
    join = Join([main, JoinInput("back", joined=False, sampled=sampled)], lateness=0)
    bench.queues[0].put(tick(0))
    bench.queues[0].put(tick(10))
    assert fire(join) is not None
    assert join.ready() is None
    bench.queues[1].accept(Watermark(1))
    assert join.ready() == 10


def test_latest_forward_input_is_sampled_by_capture_time_not_by_arrival() -> None:
    bench = Bench(2)
    sampled = NewestInput(bench.queues[1], delay=0, timed=True, initial=None)
    main = JoinInput("in", joined=False, members=(bench.queues[0],))
    join = Join([main, JoinInput("latest", joined=False, sampled=sampled)], lateness=0)
    bench.queues[1].put(tick(3, 3))
    bench.queues[1].put(tick(4, 4))
    bench.queues[1].put(tick(20, 20))
    bench.queues[0].put(tick(10))
    assert fire(join)[1].value == 4  # type: ignore[index,attr-defined]
    assert bench.ledger.count(1).dropped == 1


def test_of_a_fast_stream_the_nearest_is_taken_as_soon_as_it_is_known() -> None:
    bench = Bench(2)
    join = bench.plain()
    for time in (0, 3, 6):
        bench.put(1, tick(time * MS, time))
    bench.put(0, tick(7 * MS))
    assert join.ready() is None, "8 would be nearer than 6"
    bench.queues[1].advance(8 * MS)
    assert [message.value for message in fire(join)] == [0, 6]  # type: ignore[union-attr,attr-defined]
    assert bench.ledger.count(1).unmatched == 2


def test_the_nearest_of_a_fast_stream_does_not_break_up_a_join_that_is_complete() -> None:
    bench = Bench(3)
    join = bench.plain()
    for edge, time in ((2, -40), (0, 0), (1, 39), (2, 0), (2, 41)):
        bench.put(edge, tick(time * MS // 10, time))
    assert [message.value for message in fire(join)] == [0, 39, 0]  # type: ignore[union-attr,attr-defined]


def windowed(bench: Bench, sampled: SampledInput) -> Join:
    main = JoinInput("in", joined=False, members=(bench.queues[0],))
    return Join([main, JoinInput("readings", joined=False, sampled=sampled)], lateness=0)


def values(argument: object) -> list[int]:
    return [message.value for message in argument]  # type: ignore[attr-defined]


def test_a_live_window_fires_at_the_deadline_and_what_is_late_comes_in_the_next_one() -> None:
    bench = Bench(2)
    join = windowed(bench, WindowInput(bench.queues[1:]))
    bench.put(1, tick(3, 3))
    bench.put(0, tick(10))
    assert join.ready() is None, "a reading of 10 may still come"
    assert join.ready(overdue=True) == 10
    assert values(join.take(10)[0][1]) == [3]
    bench.put(1, tick(9, 9))
    bench.put(1, tick(12, 12))
    bench.put(0, tick(20))
    assert join.ready() is None
    bench.queues[1].advance(20)
    assert join.ready() is None, "one of 20 may still come"
    bench.queues[1].advance(21)
    assert join.ready() == 20
    assert values(join.take(20)[0][1]) == [9, 12]
    assert bench.ledger.count(1).balanced
    assert bench.ledger.count(1).delivered == 3


def test_a_live_nearest_gives_at_the_deadline_what_is_there() -> None:
    bench = Bench(2)
    join = windowed(bench, NearestInput(bench.queues[1], tolerance=5))
    bench.put(1, tick(7, 7))
    bench.put(0, tick(10))
    assert join.ready() is None, "12 would be nearer"
    assert join.ready(overdue=True) == 10
    assert join.take(10)[0][1].value == 7  # type: ignore[attr-defined]


def test_a_nearest_is_certain_as_soon_as_nothing_can_be_nearer() -> None:
    bench = Bench(2)
    join = windowed(bench, NearestInput(bench.queues[1], tolerance=5))
    bench.put(1, tick(7, 7))
    bench.put(0, tick(10))
    bench.queues[1].advance(12)
    assert join.ready() is None
    bench.queues[1].advance(13)
    assert join.ready() == 10, "13 would be no nearer than 7"


def test_nothing_is_near_only_when_nothing_can_come_within_the_tolerance() -> None:
    bench = Bench(2)
    join = windowed(bench, NearestInput(bench.queues[1], tolerance=5))
    bench.put(1, tick(4, 4))
    bench.put(0, tick(10))
    bench.queues[1].advance(15)
    assert join.ready() is None, "15 would be near enough"
    bench.put(1, tick(15, 15))
    assert join.take(10)[0][1].value == 15  # type: ignore[attr-defined]
    bench.put(0, tick(30))
    bench.queues[1].advance(36)
    assert join.ready() == 30
    assert join.take(30)[0][1] is None


def test_feedback_is_waited_for_beyond_a_deadline() -> None:
    bench = Bench(2)
    join = windowed(bench, NewestInput(bench.queues[1], delay=1, timed=True, initial=Tick.empty()))
    bench.put(0, tick(0))
    bench.put(0, tick(10))
    assert fire(join) is not None
    assert join.ready(overdue=True) is None


def test_a_full_feedback_edge_keeps_the_message_of_the_firing_before() -> None:
    bench = Bench(2)
    bench.queues[1].depth = 2
    back = NewestInput(bench.queues[1], delay=1, timed=True, initial=Tick.empty())
    main = JoinInput("in", joined=False, members=(bench.queues[0],))
    join = Join([main, JoinInput("back", joined=False, sampled=back)], lateness=0, lag=0)
    bench.put(0, tick(10))
    assert fire(join) is not None
    for time in (10, 11, 12):
        bench.put(1, tick(time, time))
    bench.queues[0].advance(20)
    join.relieve_backpressure(join.watermark())
    assert len(bench.queues[1].messages) == 3 < bench.queues[1].depth
    bench.put(0, tick(20))
    assert fire(join)[1].value == 10  # type: ignore[index,attr-defined]


def test_a_full_edge_lets_its_sender_go_on_where_another_input_is_awaited() -> None:
    bench = Bench(2)
    bench.queues[1].depth = 2
    main = JoinInput("in", joined=False, members=(bench.queues[0],))
    readings = JoinInput("readings", joined=False, sampled=WindowInput(bench.queues[1:]))
    join = Join([main, readings], lateness=0, lag=0)
    bench.queues[0].advance(4)
    for time in (2, 3, 5, 6):
        bench.put(1, tick(time, time))
    join.relieve_backpressure(join.watermark())
    assert len(bench.queues[1].messages) == bench.queues[1].depth == 4, "5 and 6 fill it"
    bench.put(0, tick(5))
    assert values(fire(join)[1]) == [2, 3, 5]  # type: ignore[index]
    assert bench.queues[1].depth == 2, "what was exempt is gone"
