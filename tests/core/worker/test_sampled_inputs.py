"""What `Latest`, `Nearest` and `Window` give a firing, and when that is known."""

from __future__ import annotations

from tests.core.worker.joined import MS, Bench, fire, tick, values, windowed

from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.inputs.sampled_input import NearestInput, NewestInput, WindowInput


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
