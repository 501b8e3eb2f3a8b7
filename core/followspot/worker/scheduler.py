"""The scheduler of a worker: one thread fires ready stages, and pulls sources when no stage is ready.

Stages nearest to the sinks fire first, so messages in flight are finished before sources yield more. The
order never changes a result, for a firing depends on the streams alone. Backpressure reaches a stage through
its outputs: a stage without credit is blocked until a reader wakes the worker.
"""

from __future__ import annotations

import select
import sys
import time
from collections import deque
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass
from functools import partial
from heapq import heappop, heappush
from operator import attrgetter

from followspot.control.dispatch import Handlers
from followspot.control.lifecycle import StopRun
from followspot.control.worker_orders import HoldSources
from followspot.errors import FollowspotError
from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.token import END
from followspot.transport.wakeup_event import WakeupEvent
from followspot.worker.batch_group import batch_groups
from followspot.worker.input_queue import InputQueue
from followspot.worker.pace import Pace
from followspot.worker.source import LiveSourceRunner, SourceRunner
from followspot.worker.stage_runner import StageError, StageRunner

_FIRINGS_PER_TURN = 32
"""Firings between two polls of what other workers sent."""
_LONGEST_SLEEP_MS = 100
"""Longest sleep, ms: what a missed wake-up costs at most."""
_SWITCH_INTERVAL = 0.0005
"""Seconds that one thread may keep the interpreter; live sources and Zenoh have threads of their own."""


_ALL = range(sys.maxsize)
"""Rows of all edges."""
_watermark = attrgetter("watermark")


class StuckError(FollowspotError):
    """No stage can fire, no source can yield, and yet the streams have not ended."""


@dataclass(frozen=True)
class Progress:
    """How far a worker or a run has come."""

    fired: int
    """Firings of the sink that is furthest behind; of the sources if there are no sinks."""
    time: int
    """Newest capture time that a source sent, ns; -1 before the first."""
    faults: tuple[str, ...] = ()
    """Of a run: one line for each part that is absent or silent."""


class Worker:
    """Runs the stage runners of one process.

    runners: in topological order; readers: input queues that other workers feed; writers: each with the rank
    of the stage runner that owns it; pace: the sources wait with it.
    """

    def __init__(
        self,
        runners: Sequence[StageRunner],
        readers: Sequence[InputQueue],
        writers: Sequence[tuple[PortWriter, int]],
        pace: Pace,
    ) -> None:
        self.runners = tuple(runners)
        self.sources = tuple(runner for runner in runners if isinstance(runner, SourceRunner))
        self.live = tuple(runner for runner in self.sources if isinstance(runner, LiveSourceRunner))
        self.readers = tuple(readers)
        self.writers = tuple(writers)
        self.pace = pace
        self.regroup()
        self._ready: list[int] = []
        self._marked = [False] * len(runners)
        self._stopping = False
        self.hold: HoldSources | None = None
        self._hold_at = 0
        """Messages of the source that the hold names, after which it holds."""
        self._actions: deque[Callable[[], None]] = deque()
        self._poll = select.poll()
        self._watched: dict[int, Callable[[], bool]] = {}
        self._wakeup = WakeupEvent()
        self._connect()

    @property
    def handlers(self) -> Handlers:
        """The orders that the scheduler carries out."""
        return {StopRun: lambda _: self.stop(), HoldSources: self._set_hold}

    def holds(self, source: SourceRunner) -> bool:
        """Whether this source sends nothing now, because the operator holds it."""
        hold = self.hold
        if hold is None:
            return False
        if source.name == hold.source:
            return source.yielded >= self._hold_at
        here = (other.watermark for other in self.sources if other.name == hold.source)
        return source.watermark >= max(here, default=hold.until)

    def _set_hold(self, order: HoldSources) -> None:
        if order.held and (self.hold is None or self.hold.id != order.id):
            yielded = (source.yielded for source in self.sources if source.name == order.source)
            self._hold_at = sum(yielded) + order.count
        self.hold = order if order.held else None

    def mark(self, rank: int) -> None:
        """Schedule this stage runner: its inputs or outputs changed."""
        if not self._marked[rank]:
            self._marked[rank] = True
            heappush(self._ready, -rank)

    def mark_waiting(self, runner: StageRunner) -> None:
        """Schedule this stage runner after feedback came, if it has messages to fire with."""
        if runner.done:
            self.mark(runner.rank)
            return
        for queue in runner.join.members:
            if queue.messages:
                self.mark(runner.rank)
                return

    def regroup(self) -> None:
        """Form the batch groups of the stages that are alike now."""
        self.batch_groups = batch_groups(self.runners, self.mark)
        self._steps: list[Callable[[], None]] = [runner.step for runner in self.runners]
        for group in self.batch_groups:
            for runner in group.runners:
                self._steps[runner.rank] = partial(group.step, runner)

    def fire_waiting(self) -> bool:
        """Fire the ready members of a batch group without the others; False if no member waits."""
        for group in self.batch_groups:
            if group.waiting:
                group.fire()
                return True
        return False

    def between_firings(self, action: Callable[[], None]) -> None:
        """Let the worker's thread call `action` as soon as no stage is at work. Safe from any thread."""
        self._actions.append(action)
        self.wake()

    def watch(self, fd: int, callback: Callable[[], bool]) -> None:
        """Call back when the descriptor is readable, until the callback returns True."""
        self._watched[fd] = callback
        self._poll.register(fd, select.POLLIN)

    def adopt_reader(self, old: PortReader, new: PortReader) -> None:
        """Read from `new`: the worker that wrote to `old` was started again."""
        queue = next(queue for queue in self.readers if queue.reader is old)
        self._unwatch(old.fileno())
        queue.adopt(new)
        self.watch(new.fileno(), queue.poll)

    def adopt_link(self, writer: PortWriter, fd: int) -> None:
        """Watch `fd` for credit: the worker that reads from `writer` was started again."""
        rank = next(rank for known, rank in self.writers if known is writer)
        self.watch(fd, partial(self._credited, fd, writer, rank))
        for _, output in self.runners[rank].outputs:
            output.update_readers()
            output.returned(writer)
        self.mark(rank)

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
            self.mark(runner.rank)

    def stop(self) -> None:
        """End all sources; messages in flight are still processed. Safe in signal handlers and threads."""
        self._stopping = True
        self.pace.end()
        self.wake()

    def wake(self) -> None:
        """Wake the worker from another thread."""
        self._wakeup.set()

    def setup(self) -> None:
        """Set up all stages, in order. Raises StageError."""
        sys.setswitchinterval(_SWITCH_INTERVAL)
        if "cv2" in sys.modules:
            sys.modules["cv2"].setNumThreads(1)  # workers are the parallelism
        for runner in self.runners:
            runner.setup()

    def run(self) -> None:
        """Run to the end of all streams, then close all stages. Raises StageError, StuckError."""
        problems: list[StageError] = []
        try:
            for source in self.live:
                source.start()
            for runner in self.runners:
                self.mark(runner.rank)
            while self._turn():
                pass
        finally:
            problems = self.close()
        if problems:
            raise problems[0]

    def close(self) -> list[StageError]:
        """Close all stages and edges; returns what stages raised."""
        problems = []
        for runner in self.runners:
            try:
                if isinstance(runner, LiveSourceRunner):
                    runner.stop()
                runner.close()
            except StageError as error:
                problems.append(error)
        for writer, _ in self.writers:
            writer.close()
        for runner in self.runners:
            for _, output in runner.outputs:
                output.update_readers()  # counts what was on its way to readers that were cut off
        for queue in self.readers:
            if queue.reader is not None:
                queue.reader.close()
        self._wakeup.close()
        return problems

    def progress(self) -> Progress:
        """How far the worker has come."""
        counted = [runner.count.fired for runner in self.runners if runner.is_sink] or [
            s.yielded for s in self.sources
        ]
        return Progress(min(counted, default=0), max((s.watermark for s in self.sources), default=-1))

    def expected(self) -> int | None:
        """Messages that the longest source will yield; None if no source knows."""
        known = [n for n in (source.expected() for source in self.sources) if n is not None]
        return max(known, default=None)

    def _connect(self) -> None:
        self.watch(self._wakeup.fileno(), self._clear_wakeup)
        for queue in self.readers:
            assert queue.reader is not None
            self.watch(queue.reader.fileno(), queue.poll)
        for writer, rank in self.writers:
            for fd in writer.filenos():
                self.watch(fd, partial(self._credited, fd, writer, rank))
        for source in self.live:
            source.notify = self.wake

    def _turn(self) -> bool:
        """Fire what is ready, receive, and pull a source or sleep; False when all streams have ended."""
        for _ in range(_FIRINGS_PER_TURN):
            if not self._ready:
                break
            rank = -heappop(self._ready)
            self._marked[rank] = False
            self._steps[rank]()
        if len(self._watched) > 1:
            self._receive(0)
        while self._actions:
            self._actions.popleft()()
        if self._stopping:
            self._stop_sources()
        if self._ready or self._pull() or self.fire_waiting():
            return True
        if self._finished():
            return False
        self._wait()
        return True

    def _pull(self) -> bool:
        """Pull the source with the earliest watermark, then those that are earliest; False if none yields."""
        candidates = [s for s in self.sources if not s.done and not self.holds(s)]
        candidates.sort(key=_watermark)
        reached = END
        for source in candidates:
            if source.watermark >= reached:
                break
            source.blocked = not source.has_room()
            if not source.blocked and (source.pull() or source.done):
                reached = min(reached, source.watermark)
        return reached < END

    def _finished(self) -> bool:
        """Whether all stages are done and all edges are flushed; the ledger counts even late feedback."""
        flushed = [writer.flush() for writer, _ in self.writers]
        received = all(queue.watermark == END for queue in self.readers)
        return received and all(flushed) and all(runner.done for runner in self.runners)

    def _wait(self) -> None:
        """Sleep until a message, credit, another thread or the deadline of a live join wakes the worker."""
        if self._credit_came():
            return
        deadlines = [c.overdue_at for c in self.runners if c.overdue_at is not None and not c.done]
        if not (deadlines or self.readers or self.writers or self.live or self.hold):
            raise StuckError(self._why_stuck())
        if not deadlines:
            self._receive(_LONGEST_SLEEP_MS)
            return
        left_ms = (min(deadlines) - time.monotonic()) * 1000
        self._receive(int(min(max(left_ms, 0), _LONGEST_SLEEP_MS)) + 1)
        for runner in self.runners:
            if runner.overdue_at is not None and runner.overdue_at <= time.monotonic():
                self.mark(runner.rank)

    def _credit_came(self) -> bool:
        """Ask the readers of blocked stages for a wake-up; whether credit has come already."""
        came = False
        for writer, rank in self.writers:
            runner = self.runners[rank]
            if runner.blocked:
                writer.want_credit()
                if runner.has_room():
                    self.mark(rank)
                    runner.blocked = False
                    came = True
        return came

    def _receive(self, timeout_ms: int) -> None:
        for fd, _ in self._poll.poll(timeout_ms):
            if self._watched[fd]():
                self._unwatch(fd)

    def _unwatch(self, fd: int) -> None:
        if self._watched.pop(fd, None) is not None:
            self._poll.unregister(fd)

    def _clear_wakeup(self) -> bool:
        self._wakeup.clear()
        return False

    def _credited(self, fd: int, writer: PortWriter, rank: int) -> bool:
        writer.drain()
        for _, output in self.runners[rank].outputs:
            output.update_readers()
        self.mark(rank)
        return fd not in writer.filenos()

    def _stop_sources(self) -> None:
        self._stopping = False
        self.hold = None
        self.give_up(_ALL)
        for source in self.sources:
            if not source.done:
                source.stop()

    def _why_stuck(self) -> str:
        """Name the stages that wait, and the edges for which they wait."""
        lines = []
        for runner in self.runners:
            full = [i.name for _, o in runner.outputs for i in o.queues if len(i.messages) >= i.depth]
            dry = [i.name for i in runner.join.members if not i.messages and i.watermark != END]
            if not runner.done:
                lines.append(
                    f"  {runner.name}: " + (f"full: {full}" if runner.blocked else f"waits for: {dry}")
                )
        return "the graph is stuck; raise `depth` of the full edges\n" + "\n".join(lines)
