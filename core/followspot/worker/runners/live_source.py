"""The runner of a live source: its thread takes frames from the device, and drops the oldest.

A live source delivers in its own time, so nothing can hold it up.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from followspot.frame_times import NANOSECOND
from followspot.graph.depths import LIVE_DEPTH
from followspot.message_checks.outputs import several
from followspot.messages import UNSTAMPED, Header
from followspot.stage import Stage
from followspot.worker.clock import Arrival
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.output_port import OutputPort
from followspot.worker.runners.error_policy import RAISED
from followspot.worker.runners.late_errors import tell_late_error
from followspot.worker.runners.source import NOTHING, SourceRunner
from followspot.worker.runners.stage_runner import Returned


class LiveSourceRunner(SourceRunner):
    """Runs a source that delivers in its own time: its thread keeps the newest frames and drops the oldest.

    A frame counts as produced as soon as the device gives it, so that the ledger has it even if the worker
    dies before the graph takes it.
    """

    depth: int = LIVE_DEPTH
    """Messages that wait for the worker before the oldest is dropped."""
    notify: Callable[[], None]
    """Wakes the worker from the source's thread."""
    _thread: threading.Thread | None = None
    _came: Arrival
    """When the last message came."""
    _by_host_clock = False
    """Whether capture times have been near to this host's clock: those of recordings are not."""

    def start(self) -> None:
        """Start the thread that grabs frames."""
        self._lock = threading.Lock()
        self._newest: deque[Any] = deque()
        self._grabbed = max((output.count_produced for _, output in self.outputs), default=0)
        """Messages that came, also to a worker of the run that died."""
        self._overrun = 0
        """Messages that were dropped since the worker last took one."""
        self._shut = False
        """Whether the thread may add no more."""
        for _, output in self.outputs:
            output.counts = False
        self._begin()

    @property
    def grabbing(self) -> bool:
        """Whether no frame waits for the worker: the device has yet to give one."""
        return self._thread is None or not self._newest

    def end_after(self, time: int) -> None:
        """End now: a device that falls silent would never pass the time."""
        self.stop()

    def stop(self) -> None:
        """Stop grabbing; frames that were grabbed are still sent."""
        super().stop()
        self.close()
        if self._thread is not None:
            self._thread.join(timeout=2.0)

    def replace_stage(self, stage: Stage, build: Callable[[], Stage]) -> None:
        """Take frames from another device from now on; those that the old one still gives are dropped."""
        super().replace_stage(stage, build)
        self._begin()

    def reconnect(self, readers: Mapping[str, Sequence[InputQueue]]) -> None:
        """See `StageRunner.reconnect`; frames that wait for the worker go to the new readers."""
        with self._lock:
            for port, output in self.outputs:
                output.reconnect(readers[port], self._waiting(output))

    def exchange(self, output: OutputPort, change: Callable[[], Returned]) -> Returned:
        """See `StageRunner.exchange`. The edges that come count the frames that wait for the worker."""
        with self._lock:
            before = output.all_rows
            found = change()
            output.recount(before, self._waiting(output))
        return found

    def _waiting(self, output: OutputPort) -> int:
        """How many frames wait for the worker that an output will send."""
        return sum(output in self._outputs_of(item) for item, _, _ in self._newest)

    def _begin(self) -> None:
        self._error: BaseException | None = None
        self._over = self._full
        if self._over:
            return
        self._thread = threading.Thread(target=self._grab, args=(self.stage,), name=self.name, daemon=True)
        self._thread.start()

    def _time(self, given: Header) -> int:
        """Capture time, ns, on the reference clock.

        It is the time of arrival if the device gives none, or one that leaps away from the clocks of hosts:
        the watermark would follow it, and all else would be late.
        """
        came = self._came
        if given is UNSTAMPED:
            return self.clock.capture_time(came.wall, came)
        near = came.is_near(given.time)
        self._by_host_clock |= near
        if near or not self._by_host_clock:
            return self.clock.capture_time(given.time, came)
        leap = round((given.time - came.wall) * NANOSECOND)
        what = f"capture times leap {abs(leap)} s {'ahead' if leap > 0 else 'back'}"
        self.stage.context.warn(f"{what}: those of arrival are taken; look at the clock of the device")
        return self.clock.capture_time(came.wall, came)

    def _left_out(self, item: Any, error: Exception) -> None:
        for output in self._outputs_of(item):
            output.invalid()  # its thread has counted it as produced
        super()._left_out(item, error)

    def _reopen(self) -> None:
        self._begin()

    def _grab(self, stage: Stage) -> None:
        """Take frames from the device until it ends or another stage replaces this one; in a thread."""
        try:
            for item in several(stage.process()):
                if not self._keep(item, stage):
                    break
                self.notify()
        except RAISED as error:
            if self._asked_to_end(stage):
                tell_late_error(stage, error)
            else:
                self._error = error
        if self.stage is stage:
            self._over = True
            self.notify()

    def _asked_to_end(self, stage: Stage) -> bool:
        """Whether the run ends, or the stage leaves it: what it raises then fails nothing."""
        return self.stopped or self.stage is not stage or not stage.context.pause(0.0)

    def _keep(self, item: Any, stage: Stage) -> bool:
        """Count an item and keep it for the worker; whether to go on."""
        with self._lock:
            if self._shut or self._full:
                return False
            self._grabbed += 1
            for output in self._outputs_of(item):
                output.produced()
            if self.stage is not stage:
                self._drop(item)
                return False
            if len(self._newest) == self.depth:
                self._drop(self._newest.popleft()[0])
            self._newest.append((item, self.clock.now(), self.clock.arrival()))
            return not (self.stopped or self._full)

    @property
    def _full(self) -> bool:
        """Whether all devices together have given as many frames as the run takes."""
        return self.limit is not None and self._grabbed >= self.limit

    def _drop(self, item: Any) -> None:
        """Count an item that is dropped."""
        self._overrun += 1
        for output in self._outputs_of(item):
            output.overrun()

    def _outputs_of(self, item: Any) -> Iterator[OutputPort]:
        """The outputs for which an item has a message."""
        for port, output in self.outputs:
            if self.outputs.single is not None or getattr(item, port, None) is not None:
                yield output

    def _next(self) -> Any:
        """The oldest item that waits; `NOTHING` if none does. Ends the stream behind the last one."""
        with self._lock:
            overrun, self._overrun = self._overrun, 0
            item = self._newest.popleft() if self._newest else None
            over, error = self._over, self._error  # read under the lock: later changes are seen next time
            self._shut = item is None and error is None and (over or self.stopped)
        self.yielded += overrun
        if item is not None:
            found, self.entered, self._came = item
            return found
        if error is not None:
            self._failed(error)
        elif self._shut:
            self.finish()
        return NOTHING
