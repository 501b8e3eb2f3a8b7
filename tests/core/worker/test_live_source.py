"""Every message that a live source makes is counted when it is made, whatever becomes of it then."""

from __future__ import annotations

from dataclasses import dataclass

from tests.core.worker.live_bench import Bench, Device, Note

from followspot import Context, Source, at
from followspot.worker.inputs.input_queue import InputQueue


@dataclass(frozen=True)
class Pair:
    """Two outputs, of which one may have nothing to say."""

    even: Note | None
    odd: Note | None


class Twin(Device):
    """Even numbers at one port, odd ones at the other."""

    def process(self) -> Source[Pair]:  # type: ignore[override]
        yield from self.items(lambda n: Pair(*((None, at(n, Note(n)))[:: 1 if n % 2 else -1])))  # type: ignore[arg-type,misc]


def test_what_waits_for_the_graph_is_produced_and_what_is_dropped_is_so_at_once() -> None:
    bench = Bench(Device(), "out")
    bench.begin()
    bench.device.make(5)
    assert (bench.count().produced, bench.count().dropped, bench.count().in_flight) == (5, 3, 2)
    bench.pull_all()
    assert [message.number for message in bench.queues[0].messages] == [4, 5]  # type: ignore[attr-defined]
    assert (bench.count().produced, bench.count().dropped, bench.runner.yielded) == (5, 3, 5)
    bench.runner.stop()


def test_a_deep_source_keeps_as_many_as_it_says_while_the_graph_is_busy() -> None:
    bench = Bench(Device(), "out")
    bench.runner.depth = 500
    bench.begin()
    bench.device.make(500)
    assert (bench.count().produced, bench.count().dropped) == (500, 0)
    bench.device.make(1)
    assert (bench.count().produced, bench.count().dropped) == (501, 1)
    bench.pull_all()
    assert [message.number for message in bench.queues[0].messages][:100] == list(range(2, 102))  # type: ignore[attr-defined]
    bench.runner.stop()


def test_what_waits_while_readers_change_counts_for_the_new_reader_alone() -> None:
    bench = Bench(Device(), "out")
    new = InputQueue("new", bench.ledger.words, bench.ledger.row(1), depth=100, lateness=0)
    bench.begin()
    bench.device.make(5)
    bench.runner.reconnect({"out": [new]})
    bench.device.make(1)
    bench.pull_all()
    assert [message.number for message in new.messages] == [5, 6]  # type: ignore[attr-defined]
    old, there = bench.count(0), bench.count(1)
    assert (old.produced, old.dropped, old.in_flight) == (3, 3, 0)
    assert (there.produced, there.dropped, there.in_flight, there.surplus) == (3, 1, 2, 0)
    bench.runner.stop()


def test_what_comes_while_the_device_is_told_to_stop_is_sent() -> None:
    bench = Bench(Device(), "out")
    bench.begin()
    bench.device.make(1)
    bench.runner.stop()  # closing it lets it give one more
    bench.pull_all()
    assert bench.runner.done
    assert bench.device.made == bench.count().produced == len(bench.queues[0].messages) == 2


def test_a_source_with_a_limit_takes_no_more_than_that_from_its_device() -> None:
    bench = Bench(Device(), "out")
    bench.runner.limit = 3
    bench.begin()
    bench.device.make(2)
    bench.device.wanted.release(5)
    assert bench.runner._thread is not None
    bench.runner._thread.join(60)
    bench.pull_all()
    assert bench.runner.done
    assert (bench.device.made, bench.count().produced, bench.runner.yielded) == (3, 3, 3)
    assert bench.count().dropped == 1


def test_what_the_device_before_a_swap_still_gives_is_dropped() -> None:
    first, second = Device(), Device()
    bench = Bench(first, "out")
    bench.begin()
    old = bench.runner._thread
    assert old is not None
    bench.runner.replace_stage(second, lambda: second)
    first.wanted.release()
    old.join(60)
    assert (bench.count().produced, bench.count().dropped) == (1, 1)
    assert second.asked.acquire(timeout=60)
    second.make(1)
    bench.pull_all()
    assert (bench.count().produced, bench.count().dropped, len(bench.queues[0].messages)) == (2, 1, 1)
    bench.runner.stop()


def test_a_device_that_is_built_anew_after_it_failed_counts_on() -> None:
    bench = Bench(Device(), "out")
    bench.runner.on_error = "restart"
    bench.begin()
    bench.device.make(3)
    bench.device.fails = True
    bench.device.wanted.release()
    assert bench.runner._thread is not None
    bench.runner._thread.join(60)
    bench.device.fails = False
    bench.device.context = Context(warn=lambda text: None)
    bench.pull_all()
    assert bench.device.asked.acquire(timeout=60)
    bench.device.make(1)
    bench.pull_all()
    assert (bench.count().produced, bench.count().dropped, len(bench.queues[0].messages)) == (4, 1, 3)
    bench.runner.stop()


def test_each_port_of_a_source_counts_what_it_was_given() -> None:
    bench = Bench(Twin(), "even", "odd")
    bench.begin()
    bench.device.make(5)
    bench.pull_all()
    assert [bench.count(n).produced for n in (0, 1)] == [2, 3]
    assert [bench.count(n).dropped for n in (0, 1)] == [1, 2]
    assert [len(queue.messages) for queue in bench.queues] == [1, 1]
    bench.runner.stop()


class Wrong(Device):
    """Gives what is no message of its port."""

    def process(self) -> Source[Note]:
        yield from self.items(lambda n: n)  # type: ignore[misc]


def test_a_device_that_is_built_anew_at_the_limit_gives_nothing_more() -> None:
    first, second = Wrong(), Device()
    first.context = Context(warn=lambda text: None)
    bench = Bench(first, "out")
    bench.runner.on_error, bench.runner.limit = "restart", 3
    bench.begin()
    bench.runner.build = lambda: second
    bench.device.make(2)
    bench.device.wanted.release()
    assert bench.runner._thread is not None
    bench.runner._thread.join(60)
    second.wanted.release(10)
    bench.pull_all()
    bench.runner._thread.join(60)
    assert bench.runner.done
    assert (second.made, bench.count().produced, bench.count().invalid) == (0, 3, 2)


def test_the_limit_counts_what_the_device_before_a_swap_still_gives() -> None:
    first, second = Device(), Device()
    bench = Bench(first, "out")
    bench.runner.limit = 3
    bench.begin()
    bench.device.make(2)
    old = bench.runner._thread
    bench.runner.replace_stage(second, lambda: second)
    first.wanted.release()
    assert old is not None
    old.join(60)
    second.wanted.release(10)
    assert bench.runner._thread is not None
    bench.runner._thread.join(60)
    bench.pull_all()
    assert bench.runner.done
    assert bench.count().produced == 3


def test_a_worker_that_is_started_again_takes_what_is_left_of_the_limit() -> None:
    died = Bench(Device(), "out")
    died.runner.limit = 3
    died.begin()
    died.device.make(2)
    again = Bench(Device(), "out", ledger=died.ledger)
    again.runner.limit = 3
    again.begin()
    again.device.wanted.release(5)
    assert again.runner._thread is not None
    again.runner._thread.join(60)
    again.pull_all()
    assert again.runner.done
    assert (again.device.made, again.count().produced) == (1, 3)
    died.runner.stop()
