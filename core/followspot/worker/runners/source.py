"""The runner of a source: the scheduler pulls it whenever its outputs have credit.

A message may have a time before which it is not sent: a source that plays at a pace. It is kept until then.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

from followspot.message_checks.outputs import WrongOutput, check_yielded, several
from followspot.messages import Header, InvalidMessage, in_range
from followspot.transport.token import END
from followspot.worker.runners.error_policy import RAISED, recover
from followspot.worker.runners.stage_runner import StageRunner

NOTHING = object()
"""Stands for the item of a source that has none now."""


class SourceRunner(StageRunner):
    """Runs a stage without inputs, which yields when its outputs have credit: no message is lost or piles up.

    limit: number of messages after which it ends, None for all; accompanying: whether it is a sensor's, which
    gives readings as long as others give frames.
    """

    limit: int | None = None
    accompanying = False
    last_time = END
    """Capture time, ns, after which it ends."""
    yielded = 0
    watermark = -1
    """Capture time of the last message, ns; the worker pulls the source that is furthest behind."""
    entered = 0
    """When the last message was made, ns of the monotonic clock."""
    not_before = 0
    """Earliest time to send the newest message, sent or not, ns of the monotonic clock."""
    interval = 0
    """Time between the dues of the last two messages, ns; 0 for a source that keeps no pace."""
    made_in = 0
    """How long the newest message took to make, ns."""
    exhausted = False
    """Whether the stream ended by itself."""
    stopped = False
    until = END
    """Capture time, ns, after which it sends nothing for now."""
    _items: Iterator[Any] | None = None
    """The generator of the stage; None before the first pull."""
    _kept: Any = NOTHING
    _kept_time = 0

    def pull(self) -> bool:
        """Send the next message; False if there is none now. Raises StageError."""
        item = self._kept
        if item is NOTHING or self.stopped:
            item = self._next()
            if item is NOTHING:
                return False
        elif self.early:
            return False
        else:
            self.entered = time.monotonic_ns() + self.clock.steady
        self._kept = NOTHING
        try:
            header = in_range(self._stamp(item))
        except (WrongOutput, InvalidMessage) as error:
            self._left_out(item, error)
            return True
        if header.time > self.last_time:
            self.finish()
            return False
        if self.early or header.time > self.until:
            self._kept, self._kept_time = item, header.time
            return False
        self.watermark = header.time
        self.outputs.send(item, header)
        self.yielded += 1
        self.count.fired += 1
        return True

    @property
    def early(self) -> bool:
        """Whether the next message is made and must not be sent yet."""
        return self.not_before > time.monotonic_ns()

    @property
    def keeps(self) -> bool:
        """Whether a message is made that has not been sent yet."""
        return self._kept is not NOTHING

    @property
    def at_limit(self) -> bool:
        """Whether every message up to `until` has been sent."""
        return (self.keeps and self._kept_time > self.until) or self.watermark >= self.until

    def expected(self) -> int | None:
        """How many frames will come; None if the source does not know, or gives readings with them."""
        if self.accompanying:
            return None
        length = self.stage.length()
        return self.limit if length is None or (self.limit or length) < length else length

    def expected_last_time(self) -> int | None:
        """Capture time of the last frame of a limited run, ns; None if the source does not know."""
        number = self.expected()
        return self.stage.capture_time(number - 1) if number and not self.accompanying else None

    def end_after(self, time: int) -> None:
        """End the stream before the first message after this capture time, ns."""
        self.last_time = time

    def stop(self) -> None:
        """End the stream at the next pull."""
        self.stopped = True

    def fire(self) -> bool:
        """Do nothing when readers change: the scheduler pulls sources."""
        return False

    def _next(self) -> Any:
        """The next item of the generator; `NOTHING` if it has ended or failed. Raises StageError."""
        if self.stopped or self.yielded == self.limit:
            self.finish()
            return NOTHING
        started = time.monotonic_ns()
        self.working = True
        try:
            if self._items is None:
                self._items = several(self.stage.process())
            item = next(self._items)
        except StopIteration:
            self.exhausted = True
            self.finish()
            return NOTHING
        except RAISED as error:
            self._failed(error)
            return NOTHING
        finally:
            self.working = False
        ended = time.monotonic_ns()
        self.entered = ended + self.clock.steady
        self.made_in = ended - started
        self.count.busy_ns += self.made_in
        return item

    def _failed(self, error: BaseException) -> None:
        """Apply the error policy: `restart` opens another generator, `skip` ends the stream."""
        recover(self, Header(self.name, self.yielded, max(0, self.watermark)), error)
        if self.on_error == "skip":
            self.finish()
        else:
            self._reopen()

    def _left_out(self, item: Any, error: Exception) -> None:
        """Apply the error policy to a wrong item: `skip` leaves it out, and the generator goes on."""
        recover(self, Header(self.name, self.yielded, max(0, self.watermark)), error)
        self.yielded += 1
        if self.on_error == "restart":
            self._reopen()

    def _reopen(self) -> None:
        """Begin a generator of the stage that was built again; the old one gives nothing more."""
        self._items = None

    def _stamp(self, item: Any) -> Header:
        """Header of an item: its capture time, the name of the stage, the number of the message.

        Raises WrongOutput.
        """
        given = check_yielded(self.declared, item, live=self.stage.live)
        seq = given.seq if given.seq >= 0 else self.yielded
        if not self.stage.live and given.entered != self.not_before:
            self.interval = given.entered - self.not_before if self.not_before else 0
            self.not_before = given.entered
        return Header(self.name, seq, self._time(given), self.entered)

    def _time(self, given: Header) -> int:
        return given.time
