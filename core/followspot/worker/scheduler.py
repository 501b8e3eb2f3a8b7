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

from followspot.control.dispatch import Handlers
from followspot.control.lifecycle import StopRun
from followspot.transport.edge import PortWriter
from followspot.transport.wakeup_event import WakeupEvent
from followspot.worker.edge_ends import EdgeEnds
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.pace import Pace
from followspot.worker.rest import Rest
from followspot.worker.runners.deferred_runner import DeferredRunner
from followspot.worker.runners.error_policy import StageError
from followspot.worker.runners.live_source import LiveSourceRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.schedule import Schedule
from followspot.worker.sources import Sources
from followspot.worker.stuck import StuckError

_LONGEST_SLEEP_MS = 100
"""Longest sleep, ms: a missed wake-up delays the worker by this at most."""
_SHORTEST_POLL_MS = 1
"""Shortest poll, ms, because polls count whole milliseconds; the worker sleeps through a shorter wait."""
_SWITCH_INTERVAL = 0.0005
"""Seconds that one thread may keep the interpreter; live sources and Zenoh have threads of their own."""
_ALL = range(sys.maxsize)
"""Rows of all edges."""


class Scheduler:
    """Runs the stage runners of one worker, in one thread.

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
        self.sources = Sources()
        self.schedule = Schedule()
        self._arrange(runners)
        self._stopping = False
        self._rest: Rest | None = None
        self._rounds = 0
        self._actions: deque[Callable[[], None]] = deque()
        self.ends = EdgeEnds(self.runners, readers, writers, self.schedule.mark)
        self._wakeup = WakeupEvent()
        self.ends.watch(self._wakeup.fileno(), self._clear_wakeup)
        for source in self.sources.live:
            source.notify = self.wake

    def _arrange(self, runners: Sequence[StageRunner]) -> None:
        """Have these stage runners from now on; none is scheduled yet."""
        self.runners = tuple(runners)
        self.sources.arrange(runners)
        self.schedule.arrange(runners, in_rounds=bool(self.sources.live))

    def rearrange(self, runners: Sequence[StageRunner]) -> None:
        """Run other stage runners from now on, which are set up and connected; call between two firings.

        New live sources begin. The ends of edges to other workers stay as they are.
        """
        begun = self.sources.live
        self._arrange(runners)
        self.ends.runners = self.runners
        for source in self.sources.live:
            if source not in begun:
                source.notify = self.wake
                source.start()
        for runner in self.runners:
            self.schedule.mark(runner.rank)

    def at_rest(self, rest: Rest) -> None:
        """Act once all messages of the sources are processed. The sources hold, see `SourceHold.align`.

        Call between two firings, in the worker's thread. A later call replaces an earlier one.
        """
        self._rest = rest

    def drain(self) -> None:
        """Fire ready stages until none is ready; no source sends anything. Raises StageError."""
        while self.schedule.ready or self.schedule.fire_waiting():
            self.schedule.fire()

    @property
    def handlers(self) -> Handlers:
        """The orders that the scheduler carries out."""
        return {StopRun: lambda _: self.stop(), **self.sources.handlers}

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
            for source in self.sources.live:
                source.start()
            for runner in self.runners:
                self.schedule.mark(runner.rank)
            while self._turn():
                pass
        finally:
            problems = self.close()
        if problems:
            raise problems[0]

    def close(self) -> list[StageError]:
        """Close all stages and edges; returns the exceptions of stages."""
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

    @property
    def activity(self) -> int:
        """Firings and messages taken so far: while it stays the same, the worker has done nothing."""
        taken = sum(queue.received for queue in self.ends.readers)
        return taken + sum(runner.count.fired for runner in self.runners)

    def _turn(self) -> bool:
        """Fire ready stages, receive, and pull a source or sleep; False when all streams have ended."""
        self.schedule.fire()
        if len(self.ends.watched) > 1:  # more than the wake-up event
            self.ends.receive(0)
        while self._actions:
            self._actions.popleft()()
        if self._stopping:
            self._stop_sources()
        if self._rest is not None:
            self._act_at_rest(self._rest, idle=False)
        waiting = self._sources_wait()
        if self._rounds % (len(self.runners) or 1) == 0:  # messages that waited for a stage are processed
            self.schedule.fire_overdue()
        if waiting:
            return True
        if self.schedule.ready:
            self.sources.pull()
            self.schedule.fire_waiting()
            return True
        if self.sources.pull() or self.schedule.fire_waiting():
            return True
        if self._rest is not None:
            self._act_at_rest(self._rest, idle=True)
            return True
        if not self.sources.hold.aligned and self._finished():
            return False
        self._wait()
        return True

    def _sources_wait(self) -> bool:
        """Whether the sources wait for the ready stages.

        In a worker with live sources they wait for at most as many rounds as there are stages, so that a
        message can pass all of them. A stage that is still ready then gets messages from other workers faster
        than it works, and the sources might wait for ever.
        """
        self._rounds = self._rounds + 1 if self.schedule.ready else 0
        if self.sources.live and self._rounds >= len(self.runners):
            self._rounds = 0
        return self._rounds > 0

    def _act_at_rest(self, rest: Rest, *, idle: bool) -> None:
        """Act if the worker is at rest, or has not come to rest in time; else sleep if it is idle."""
        reached = idle and rest.reached(self.sources, self.runners)
        if reached or time.monotonic() >= rest.deadline:
            self._rest = None
            rest.act(reached)
        elif idle:
            self._wait()

    def _finished(self) -> bool:
        """Whether all stages are done and all edges are flushed; the ledger counts even late feedback."""
        return self.ends.flushed() and all(runner.done for runner in self.runners)

    def _wait(self) -> None:
        """Sleep until a message, credit, another thread, the deadline of a live join or a source's time."""
        if self.ends.credit_came():
            return
        deadlines = [c.overdue_at for c in self.runners if c.overdue_at is not None and not c.done]
        deadlines += self.sources.due()
        live = self.sources.live or self.sources.hold.holding
        asked = any(runner.asks for runner in self.runners)
        if not (deadlines or self.ends.readers or self.ends.writers or live or asked):
            raise StuckError(self.runners)
        if not deadlines:
            self.ends.receive(_LONGEST_SLEEP_MS)
            return
        left_ms = (min(deadlines) - time.monotonic()) * 1000
        if 0 < left_ms < _SHORTEST_POLL_MS:
            time.sleep(left_ms / 1000)
            self.ends.receive(0)
        else:
            self.ends.receive(min(max(int(left_ms), _SHORTEST_POLL_MS), _LONGEST_SLEEP_MS))

    def _clear_wakeup(self) -> bool:
        self._wakeup.clear()
        return False

    def _stop_sources(self) -> None:
        self._stopping = False
        self.sources.stop()
        self.ends.give_up(_ALL)
        for runner in self.runners:
            if isinstance(runner, DeferredRunner):
                runner.limit_wait()
