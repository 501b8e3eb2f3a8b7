"""The ends of edges to other workers: the scheduler waits at them for messages and for credit."""

from __future__ import annotations

import select
from collections.abc import Callable, Container, Sequence
from functools import partial

from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.token import END
from followspot.worker.input_queue import InputQueue
from followspot.worker.stage_runner import StageRunner


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
        self.readers = tuple(readers)
        self.writers = tuple(writers)
        self._mark = mark
        self._poll = select.poll()
        self.watched: dict[int, Callable[[], bool]] = {}
        """By descriptor, what to call when it is readable."""
        for queue in self.readers:
            assert queue.reader is not None
            self.watch(queue.reader.fileno(), queue.poll)
        for writer, runner in self.writers:
            for fd in writer.filenos():
                self.watch(fd, partial(self._credited, fd, writer, runner))

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
        self.watch(new.fileno(), queue.poll)

    def adopt_link(self, writer: PortWriter, fd: int) -> None:
        """Watch `fd` for credit: the worker that reads from `writer` was started again."""
        runner = next(owner for known, owner in self.writers if known is writer)
        self.watch(fd, partial(self._credited, fd, writer, runner))
        for _, output in runner.outputs:
            output.update_readers()
            output.returned(writer)
        self._mark(runner.rank)

    def give_up(self, rows: Container[int]) -> None:
        """Wait no longer for workers at the other ends of these edges: one that is away stays away.

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

    def flushed(self) -> bool:
        """True if all input streams have ended and all messages are sent; call it until it is True."""
        flushed = [writer.flush() for writer, _ in self.writers]
        return all(queue.watermark == END for queue in self.readers) and all(flushed)

    def credit_came(self) -> bool:
        """Ask the readers of blocked stages for a wake-up; True if credit has come already."""
        came = False
        for writer, runner in self.writers:
            if runner.blocked:
                writer.want_credit()
                if runner.has_room():
                    self._mark(runner.rank)
                    runner.blocked = False
                    came = True
        return came

    def close(self) -> None:
        """Close all ends, and count what was on its way to readers that were cut off."""
        for writer, _ in self.writers:
            writer.close()
        for runner in self.runners:
            for _, output in runner.outputs:
                output.update_readers()
        for queue in self.readers:
            if queue.reader is not None:
                queue.reader.close()

    def _unwatch(self, fd: int) -> None:
        if self.watched.pop(fd, None) is not None:
            self._poll.unregister(fd)

    def _credited(self, fd: int, writer: PortWriter, runner: StageRunner) -> bool:
        writer.drain()
        for _, output in runner.outputs:
            output.update_readers()
        self._mark(runner.rank)
        return fd not in writer.filenos()
