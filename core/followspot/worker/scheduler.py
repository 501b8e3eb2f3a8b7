"""The scheduler of a worker: one thread fires ready stages, and pulls sources when no stage is ready.

Stages nearest to the sinks fire first, so messages in flight are finished before sources yield more. The
order never changes a result, for a firing depends on the streams alone. Backpressure reaches a stage through
its outputs: a stage without credit is blocked until a reader wakes the worker.
"""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from heapq import heappop, heappush
from operator import attrgetter
from typing import NamedTuple

from followspot.control.dispatch import Handlers
from followspot.control.lifecycle import StopRun
from followspot.control.progress import Progress
from followspot.transport.edge import PortWriter
from followspot.transport.token import END
from followspot.transport.wakeup_event import WakeupEvent
from followspot.worker.batch_group import batch_groups
from followspot.worker.deferred_runner import DeferredRunner
from followspot.worker.edge_ends import EdgeEnds
from followspot.worker.error_policy import StageError
from followspot.worker.hold import SourceHold
from followspot.worker.input_queue import InputQueue
from followspot.worker.live_source import LiveSourceRunner
from followspot.worker.pace import Pace
from followspot.worker.source import SourceRunner
from followspot.worker.stage_runner import StageRunner
from followspot.worker.stuck import StuckError

_FIRINGS_PER_TURN = 32
"""Firings between two polls of what other workers sent."""
_LONGEST_SLEEP_MS = 100
"""Longest sleep, ms: what a missed wake-up costs at most."""
_SWITCH_INTERVAL = 0.0005
"""Seconds that one thread may keep the interpreter; live sources and Zenoh have threads of their own."""
_ALL = range(sys.maxsize)
"""Rows of all edges."""
_watermark = attrgetter("watermark")


class Rest(NamedTuple):
    """What to do once a worker is at rest. act: gets whether it is; deadline: s, monotonic, to act anyway;
    calm: says whether nothing waits that other workers have yet to complete; window: ns, see `align`.
    """

    act: Callable[[bool], None]
    deadline: float
    calm: Callable[[], bool]
    window: int


class Worker:
    """Runs the stage runners of one process.

    runners: in topological order; readers: input queues that other workers feed; writers: each with the stage
    runner that owns it; pace: the sources wait with it.
    """

    def __init__(
        self,
        runners: Sequence[StageRunner],
        readers: Sequence[InputQueue],
        writers: Sequence[tuple[PortWriter, StageRunner]],
        pace: Pace,
    ) -> None:
        self.pace = pace
        self.hold = SourceHold()
        self._arrange(runners)
        self._stopping = False
        self._rest: Rest | None = None
        self._actions: deque[Callable[[], None]] = deque()
        self.ends = EdgeEnds(self.runners, readers, writers, self.mark)
        self._wakeup = WakeupEvent()
        self.ends.watch(self._wakeup.fileno(), self._clear_wakeup)
        for source in self.live:
            source.notify = self.wake

    def _arrange(self, runners: Sequence[StageRunner]) -> None:
        """Run these from now on; none is scheduled yet."""
        self.runners = tuple(runners)
        self.sources = tuple(runner for runner in runners if isinstance(runner, SourceRunner))
        self.live = tuple(runner for runner in self.sources if isinstance(runner, LiveSourceRunner))
        self.hold.sources = self.sources
        self._ready: list[int] = []
        self._marked = [False] * len(runners)
        self.regroup()

    def rearrange(self, runners: Sequence[StageRunner]) -> None:
        """Run other stage runners from now on, which are set up and connected; call between two firings.

        New live sources begin. The ends of edges to other workers stay as they are.
        """
        begun = self.live
        self._arrange(runners)
        self.ends.runners = self.runners
        for source in self.live:
            if source not in begun:
                source.notify = self.wake
                source.start()
        for runner in self.runners:
            self.mark(runner.rank)

    def at_rest(self, rest: Rest) -> None:
        """Hold the sources at one capture time, and act once all that they sent has been processed.

        Call between two firings, in the worker's thread. Another call takes the place of the last.
        """
        self._rest = rest
        self.hold.align(rest.window)

    def drain(self) -> None:
        """Fire what is ready until nothing is; no source sends anything. Raises StageError."""
        while self._ready or self.fire_waiting():
            self._fire(len(self._ready))

    @property
    def handlers(self) -> Handlers:
        """The orders that the scheduler carries out."""
        return {StopRun: lambda _: self.stop(), **self.hold.handlers}

    def mark(self, rank: int) -> None:
        """Schedule this stage runner: its inputs or outputs changed."""
        if not self._marked[rank]:
            self._marked[rank] = True
            heappush(self._ready, -rank)

    def mark_waiting(self, runner: StageRunner, queue: InputQueue) -> None:
        """Schedule this stage runner after something came to a sampled input.

        It need not be if it has no messages to fire with, unless the edge is full.
        """
        if runner.done or len(queue.messages) >= queue.depth:
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
        self.ends.close()
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

    def _turn(self) -> bool:
        """Fire what is ready, receive, and pull a source or sleep; False when all streams have ended."""
        self._fire(_FIRINGS_PER_TURN)
        if len(self.ends.watched) > 1:  # more than the wake-up event
            self.ends.receive(0)
        while self._actions:
            self._actions.popleft()()
        if self._stopping:
            self._stop_sources()
        if self._rest is not None:
            self._rests(self._rest, idle=False)
        if self._ready or self._pull() or self.fire_waiting():
            return True
        if self._rest is not None:
            self._rests(self._rest, idle=True)
            return True
        if self._finished():
            return False
        self._wait()
        return True

    def _fire(self, most: int) -> None:
        """Let up to so many stage runners step that are scheduled."""
        for _ in range(most):
            if not self._ready:
                break
            rank = -heappop(self._ready)
            self._marked[rank] = False
            self._steps[rank]()

    def _rests(self, rest: Rest, *, idle: bool) -> None:
        """Act if the worker is at rest, or has not come to rest in time; else sleep if it is idle."""
        still = all(source.done or self.hold.holds(source) for source in self.sources)
        reached = idle and still and rest.calm() and not any(runner.asks for runner in self.runners)
        if reached or time.monotonic() >= rest.deadline:
            self._rest = None
            try:
                rest.act(reached)
            finally:
                self.hold.set_free()
        elif idle:
            self._wait()

    def _pull(self) -> bool:
        """Pull the source with the earliest watermark, then those that are earliest; False if none yields.

        While a source waits to send a message, none that is ahead of it goes on.
        """
        candidates = [s for s in self.sources if not s.done and not self.hold.holds(s)]
        candidates.sort(key=_watermark)
        pulled, reached = False, END
        for source in candidates:
            if source.watermark >= reached:
                break
            source.blocked = not source.has_room()
            if source.blocked:
                continue
            if source.pull() or source.done:
                pulled, reached = True, min(reached, source.watermark)
            elif source.keeps and not self.hold.holds(source):
                reached = min(reached, source.watermark + 1)
        return pulled

    def _finished(self) -> bool:
        """Whether all stages are done and all edges are flushed; the ledger counts even late feedback."""
        return self.ends.flushed() and all(runner.done for runner in self.runners)

    def _wait(self) -> None:
        """Sleep until a message, credit, another thread, the deadline of a live join or a source's time."""
        if self.ends.credit_came():
            return
        deadlines = [c.overdue_at for c in self.runners if c.overdue_at is not None and not c.done]
        deadlines += [
            s.not_before / 1e9 for s in self.sources if s.keeps and not s.done and not self.hold.holds(s)
        ]
        others = deadlines or self.ends.readers or self.ends.writers or self.live or self.hold.holding
        if not (others or any(runner.asks for runner in self.runners)):
            raise StuckError(self.runners)
        if not deadlines:
            self.ends.receive(_LONGEST_SLEEP_MS)
            return
        left_ms = (min(deadlines) - time.monotonic()) * 1000
        self.ends.receive(int(min(max(left_ms, 0), _LONGEST_SLEEP_MS)) + 1)
        for runner in self.runners:
            if runner.overdue_at is not None and runner.overdue_at <= time.monotonic():
                self.mark(runner.rank)

    def _clear_wakeup(self) -> bool:
        self._wakeup.clear()
        return False

    def _stop_sources(self) -> None:
        self._stopping = False
        self.hold.release()
        self.hold.set_free()
        self.ends.give_up(_ALL)
        for source in self.sources:
            if not source.done:
                source.stop()
        for runner in self.runners:
            if isinstance(runner, DeferredRunner):
                runner.hurry()
