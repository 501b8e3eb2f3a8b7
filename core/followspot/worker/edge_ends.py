"""The ends of edges to other workers: the scheduler waits at them for messages and for credit."""

from __future__ import annotations

import select
from collections.abc import Callable, Collection, Container, Iterable, Sequence
from functools import partial

from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.ring.reader import RingReader
from followspot.transport.token import END
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.runners.stage_runner import StageRunner


class EdgeEnds:
    """Polls the descriptors of a worker's edges, and reconnects edges to workers that were started again.

    readers: input queues that other workers feed; writers: each with the stage runner that owns it; mark:
    schedules the stage runner of a rank.
    """

    def __init__(
        self,
        runners: Sequence[StageRunner],
        readers: Sequence[InputQueue],
        writers: Sequence[tuple[PortWriter, StageRunner]],
        mark: Callable[[int], None],
    ) -> None:
        self.runners = runners
        self.readers: tuple[InputQueue, ...] = ()
        self.writers: tuple[tuple[PortWriter, StageRunner], ...] = ()
        self._mark = mark
        self._poll = select.poll()
        self.watched: dict[int, Callable[[], bool]] = {}
        """By descriptor, what to call when it is readable."""
        self.add(readers, writers)

    def add(self, readers: Iterable[InputQueue], writers: Iterable[tuple[PortWriter, StageRunner]]) -> None:
        """Poll these ends, too."""
        for queue in readers:
            assert queue.reader is not None
            self.readers += (queue,)
            self._watch_reader(queue, queue.reader)
        for writer, runner in writers:
            self.writers += ((writer, runner),)
            for fd in writer.filenos():
                self.watch(fd, partial(self._credited, fd, writer, runner))

    def remove(self, readers: Collection[InputQueue], writers: Collection[PortWriter]) -> None:
        """Poll these ends no longer; they stay open."""
        for queue in readers:
            if queue.reader is not None:
                self._unwatch(queue.reader.fileno())
            if isinstance(queue.reader, RingReader):
                queue.reader.notify = _ignore
        for fd in (fd for writer in writers for fd in writer.filenos()):
            self._unwatch(fd)
        self.readers = tuple(queue for queue in self.readers if queue not in readers)
        self.writers = tuple(found for found in self.writers if found[0] not in writers)

    def dismiss(self, writer: PortWriter, readers: Sequence[int]) -> None:
        """Let readers of a writer go that has others. readers: their indices."""
        before = set(writer.filenos())
        for index in readers:
            writer.dismiss(index)
        for fd in before - set(writer.filenos()):
            self._unwatch(fd)

    def watch(self, fd: int, callback: Callable[[], bool]) -> None:
        """Call back when the descriptor is readable, until the callback returns True."""
        self.watched[fd] = callback
        self._poll.register(fd, select.POLLIN)

    def receive(self, timeout_ms: int) -> None:
        """Wait until a descriptor is readable, and call back for all that are."""
        for fd, _ in self._poll.poll(timeout_ms):
            if self.watched[fd]():
                self._unwatch(fd)

    def adopt_reader(self, old: PortReader, new: PortReader) -> None:
        """Read from `new`: the worker that wrote to `old` was started again."""
        queue = next(queue for queue in self.readers if queue.reader is old)
        self._unwatch(old.fileno())
        queue.adopt(new)
        self._watch_reader(queue, new)

    def adopt_link(self, writer: PortWriter, fd: int) -> None:
        """Watch `fd` for credit: the worker that reads from `writer` was started again."""
        runner = next(owner for known, owner in self.writers if known is writer)
        self.watch(fd, partial(self._credited, fd, writer, runner))
        for _, output in runner.outputs:
            output.update_readers()
            output.returned(writer)
        self._mark(runner.rank)

    def give_up(self, rows: Container[int]) -> None:
        """Stop waiting for the workers at the other ends of these edges.

        If such a worker is lost, now or later, its streams end, and outputs do not wait for its return.

        rows: ledger rows of the edges.
        """
        for queue in self.readers:
            if queue.row in rows:
                queue.after_loss = END
                queue.poll()
        for runner in self.runners:
            for _, output in runner.outputs:
                output.waits_for_readers &= not any(row in rows for group in output.rows for row in group)
            self._mark(runner.rank)

    def all_sent(self) -> bool:
        """True if no message waits to be sent; call it until it is True."""
        flushed = [writer.flush() for writer, _ in self.writers]
        return all(flushed)

    def nothing_in_transit(self) -> bool:
        """False if anything is known to be on its way to or from other workers: sent and not yet taken."""
        taken = all(writer.all_taken for writer, _ in self.writers)
        return taken and all(queue.reader is None or queue.reader.caught_up for queue in self.readers)

    def report_at_once(self, at_once: bool) -> None:
        """Report every message to its sender as soon as it is taken here, or again only now and then.

        `nothing_in_transit` of the sending worker waits for these reports.
        """
        for queue in self.readers:
            if queue.reader is not None:
                queue.reader.report_at_once(at_once)

    def flushed(self) -> bool:
        """True if all input streams have ended and all messages are sent; call it until it is True."""
        sent = self.all_sent()
        return all(queue.watermark == END for queue in self.readers) and sent

    def credit_came(self) -> bool:
        """Ask the readers that block stages for a wake-up; True if one has given credit already."""
        came = False
        for writer, runner in self.writers:
            if runner.blocked:
                writer.want_credit()
                if runner.outputs.has_room():
                    self._mark(runner.rank)
                    runner.blocked = False
                    came = True
        return came

    def close(self) -> None:
        """Close all ends, and count the messages on their way to readers that were cut off."""
        for writer, _ in self.writers:
            writer.close()
        for runner in self.runners:
            for _, output in runner.outputs:
                output.update_readers()
        for queue in self.readers:
            if queue.reader is not None:
                queue.reader.close()

    def _watch_reader(self, queue: InputQueue, reader: PortReader) -> None:
        """Poll the queue when messages arrive for its reader: at its descriptor, or at another reader's."""
        self.watch(reader.fileno(), queue.poll)
        if isinstance(reader, RingReader):
            reader.notify = queue.poll

    def _unwatch(self, fd: int) -> None:
        if self.watched.pop(fd, None) is not None:
            self._poll.unregister(fd)

    def _credited(self, fd: int, writer: PortWriter, runner: StageRunner) -> bool:
        writer.drain()
        for _, output in runner.outputs:
            output.update_readers()
        self._mark(runner.rank)
        return fd not in writer.filenos()


def _ignore() -> None:
    """Do nothing: nothing is read any more from an edge that has left the graph."""
