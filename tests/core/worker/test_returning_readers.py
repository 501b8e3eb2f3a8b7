"""Readers that a worker finds before its first firing, or does not reach again before its end."""

from __future__ import annotations

import threading
import time

from followspot import Context, Message, Source, Stage, at
from followspot.transport.token import END, Token, Watermark
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter, open_session
from followspot.worker.inputs.join import Join
from followspot.worker.ledger import Ledger
from followspot.worker.output_port import OutputPort
from followspot.worker.pace import Pace
from followspot.worker.runners.source import SourceRunner
from followspot.worker.scheduler import Scheduler


class Note(Message):
    number: int


class Count(Stage):
    """Three numbers."""

    def process(self) -> Source[Note]:
        for n in range(3):
            yield at(n, Note(n))


def wait_for_each_other(writer: ZenohWriter, reader: ZenohReader, deadline: float) -> None:
    while not all([writer.matched(), reader.matched()]) and time.monotonic() < deadline:
        time.sleep(0.005)


def counting(writer: ZenohWriter, output: OutputPort, ledger: Ledger) -> tuple[SourceRunner, Scheduler]:
    """The source of three numbers, set up, which sends by the writer."""
    output.attach(writer, ["count.out -> save.in"], [ledger.row(0)])
    runner = SourceRunner("count", 0, lambda: Count(Context()), Join((), lateness=0), {"out": output})
    scheduler = Scheduler([runner], [], [(writer, runner)], Pace())
    scheduler.setup()
    return runner, scheduler


def test_a_writer_that_was_started_again_counts_what_it_sends_to_readers_that_it_found_at_the_barrier() -> (
    None
):
    ledger = Ledger(1)
    output = OutputPort(Note, ledger.words, lateness=0)
    with open_session() as session:
        writer = ZenohWriter(session, "test/out", {"0": ""}, 8, incarnation=1)
        reader = ZenohReader(session, "test/out", "0", Note, 8)
        deadline = time.monotonic() + 60
        wait_for_each_other(writer, reader, deadline)
        _, scheduler = counting(writer, output, ledger)
        thread = threading.Thread(target=scheduler.run, daemon=True)
        thread.start()
        tokens: list[Token] = []
        while Watermark(END) not in tokens and time.monotonic() < deadline:
            tokens += reader.poll()
        thread.join(60)
        reader.close()
    assert sum(isinstance(token, Note) for token in tokens) == 3
    count = ledger.count(0)
    assert (count.produced, count.away, count.sent) == (3, 0, 3)


def test_what_was_on_its_way_to_a_reader_that_is_not_reached_again_is_lost_at_the_end() -> None:
    ledger = Ledger(1)
    output = OutputPort(Note, ledger.words, lateness=0)
    with open_session() as session:
        writer = ZenohWriter(session, "test/out", {"0": ""}, 8)
        reader = ZenohReader(session, "test/out", "0", Note, 8)
        deadline = time.monotonic() + 60
        wait_for_each_other(writer, reader, deadline)
        runner, scheduler = counting(writer, output, ledger)
        while runner.pull():
            pass
        reader.close()
        while not writer.lost and time.monotonic() < deadline:
            writer.drain()
        output.update_readers()
        assert ledger.count(0).in_flight == 3, "it may come back"
        scheduler.close()
    count = ledger.count(0)
    assert (count.sent, count.lost, count.in_flight) == (3, 3, 0)
