"""Feedback: inputs with a delay, and edges that are full."""

from __future__ import annotations

import pytest
from tests.core.worker.joined import Bench, Tick, fire, tick, values, windowed

from followspot.transport.token import Watermark
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.inputs.sampled_input import NewestInput, WindowInput


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
