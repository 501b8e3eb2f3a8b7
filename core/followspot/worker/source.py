"""Sources at work: pulled one message at a time, or live on a thread of their own with the oldest dropped."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

from followspot.messages import UNSTAMPED, Header, InvalidMessage, in_range
from followspot.outputs import WrongOutput, check_yielded
from followspot.stage import Stage
from followspot.worker.output_port import OutputPort
from followspot.worker.stage_runner import StageRunner

LIVE_DEPTH = 2
"""Frames that wait for the graph before the oldest is dropped: one to take, one being written."""
_NOTHING = object()
"""Stands for an item that a source has not got now."""


class SourceRunner(StageRunner):
    """A stage without inputs. It yields when its outputs have room: nothing is lost, nothing piles up.

    limit: number of messages after which it ends, None for all.
    """

    limit: int | None = None
    yielded = 0
    watermark = -1
    """Capture time of the last message, ns; the worker pulls the source that is furthest behind."""
    entered = 0
    """When the last message was made, ns of the monotonic clock."""
    stopped = False
    _items: Iterator[Any] | None = None

    def pull(self) -> bool:
        """Send the next message; False where there is none now. Raises StageError."""
        item = self._next()
        if item is _NOTHING:
            return False
        try:
            header = in_range(self._stamp(item))
        except (WrongOutput, InvalidMessage) as error:
            self._left_out(item, error)
            return True
        self.watermark = header.time
        self.send(item, header)
        self.yielded += 1
        self.count.fired += 1
        return True

    def expected(self) -> int | None:
        """How many messages will come, where the source knows."""
        length = self.stage.length()
        return self.limit if length is None or (self.limit or length) < length else length

    def stop(self) -> None:
        """End at the next pull, as if the stream had ended."""
        self.stopped = True

    def step(self) -> None:
        """A source has nothing to do when its readers change; the worker pulls it."""

    def _next(self) -> Any:
        if self.stopped or self.yielded == self.limit:
            self.finish()
            return _NOTHING
        started = time.monotonic_ns()
        self.working = True
        try:
            if self._items is None:
                self._items = iter(self.stage.process())
            item = next(self._items)
        except StopIteration:
            self.finish()
            return _NOTHING
        except Exception as error:
            self._failed(error)
            return _NOTHING
        finally:
            self.working = False
        ended = time.monotonic_ns()
        self.entered = ended + self.clock.steady
        self.count.busy_ns += ended - started
        return item

    def _failed(self, error: Exception) -> None:
        """A generator that raised is over: `restart` opens it anew, `skip` ends the stream."""
        self._recover(Header(self.name, self.yielded, max(0, self.watermark)), error)
        if self.on_error == "skip":
            self.finish()
        else:
            self._open_anew()

    def _left_out(self, item: Any, error: Exception) -> None:
        """A generator that yielded what it must not can go on: `skip` leaves that out alone."""
        self._recover(Header(self.name, self.yielded, max(0, self.watermark)), error)
        self.yielded += 1
        if self.on_error == "restart":
            self._open_anew()

    def _open_anew(self) -> None:
        """The stage was built anew; what the generator of the old one has yet to give is not taken."""
        self._items = None

    def _stamp(self, item: Any) -> Header:
        """The header of what the source yielded: its capture time, the runtime's name and number.

        Raises WrongOutput.
        """
        given = check_yielded(self.declared, item, live=self.stage.live)
        seq = given.seq if given.seq >= 0 else self.yielded
        return Header(self.name, seq, self._time(given), self.entered)

    def _time(self, given: Header) -> int:
        return given.time


class LiveSourceRunner(SourceRunner):
    """A source that delivers in its own time. Its thread keeps the newest frames; the oldest is dropped.

    What the device gives counts as produced in that very moment, so that it stands in the ledger whatever
    happens to the worker before the graph takes it.
    """

    notify: Callable[[], None]
    """Wakes the worker from the source's thread."""
    _thread: threading.Thread | None = None
    _came = 0
    """When the last message was there, ns since 1970 by the clock of this host."""

    def start(self) -> None:
        """Begin to grab."""
        self._lock = threading.Lock()
        self._box: deque[Any] = deque()
        self._grabbed = self._overrun = 0
        """Messages that came; those of them that were dropped since the worker last looked."""
        self._shut = False
        """Whether nothing more is taken from the thread."""
        for _, output in self.outputs:
            output.counts = False
        self._begin()

    @property
    def grabbing(self) -> bool:
        """Whether nothing waits for the worker: the device has yet to give it."""
        return self._thread is None or not self._box

    def stop(self) -> None:
        """Stop grabbing; what was grabbed is still sent."""
        super().stop()
        self.close()
        if self._thread is not None:
            self._thread.join(timeout=2.0)

    def succeed(self, stage: Stage, build: Callable[[], Stage]) -> None:
        """Another device delivers from now on; what the old one's thread has yet to give is dropped."""
        super().succeed(stage, build)
        self._begin()

    def _begin(self) -> None:
        self._error: Exception | None = None
        self._over = False
        self._thread = threading.Thread(target=self._grab, args=(self.stage,), name=self.name, daemon=True)
        self._thread.start()

    def _time(self, given: Header) -> int:
        """By the clock of all; of a camera that has no clock, the time at which its picture came."""
        return self.clock.capture_time(self._came if given is UNSTAMPED else given.time)

    def _left_out(self, item: Any, error: Exception) -> None:
        for output in self._said(item):
            output.invalid()  # it counts as produced
        super()._left_out(item, error)

    def _open_anew(self) -> None:
        self._begin()

    def _grab(self, stage: Stage) -> None:
        try:
            for item in stage.process():
                if not self._keep(item, stage):
                    break
                self.notify()
        except Exception as error:
            if self.stage is stage:
                self._error = error
        if self.stage is stage:
            self._over = True
            self.notify()

    def _keep(self, item: Any, stage: Stage) -> bool:
        """Count what came and put it into the box; whether more is wanted."""
        with self._lock:
            if self._shut:
                return False
            self._grabbed += 1
            for output in self._said(item):
                output.produced()
            if self.stage is not stage:
                self._drop(item)
                return False
            if len(self._box) == LIVE_DEPTH:
                self._drop(self._box.popleft()[0])
            self._box.append((item, self.clock.now(), time.time_ns()))
            return not self.stopped and self._grabbed != self.limit

    def _drop(self, item: Any) -> None:
        self._overrun += 1
        for output in self._said(item):
            output.overrun()

    def _said(self, item: Any) -> Iterator[OutputPort]:
        """The outputs that have a message in what came."""
        for port, output in self.outputs:
            if self.single is not None or getattr(item, port, None) is not None:
                yield output

    def _next(self) -> Any:
        with self._lock:
            overrun, self._overrun = self._overrun, 0
            item = self._box.popleft() if self._box else None
            over, error = self._over, self._error  # now, for what came later would be in the box by then
            self._shut = item is None and error is None and (over or self.stopped)
        self.yielded += overrun
        if item is not None:
            found, self.entered, self._came = item
            return found
        if error is not None:
            self._failed(error)
        elif self._shut:
            self.finish()
        return _NOTHING
