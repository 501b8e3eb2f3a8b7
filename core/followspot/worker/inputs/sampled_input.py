"""Sampled inputs: they never fire a stage, and give a firing the messages for its capture time.

All but `Latest` in a live run go by capture time and wait for the watermark, so what a firing gets depends on
the streams alone.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from operator import attrgetter

from followspot.messages import Message
from followspot.transport.token import END
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.ledger import DROPPED, UNMATCHED

_BEFORE_ALL = -END - 1
"""Earlier than any watermark: the first firings with a feedback edge wait for nothing."""
_capture_time = attrgetter("header.time")


class SampledInput(ABC):
    """An input that never fires; queues: of its edges."""

    __slots__ = ("queues",)

    outlasts_deadline = False
    """Whether a live stage waits for it beyond its deadline: feedback comes for certain."""
    column = UNMATCHED
    """Ledger column of messages that no firing will get."""

    def __init__(self, queues: Sequence[InputQueue]) -> None:
        self.queues = tuple(queues)

    @abstractmethod
    def ready(self, time: int) -> bool:
        """Whether the sample for the next firing, at `time`, ns, is certain."""

    @abstractmethod
    def sample(self, time: int) -> object:
        """The argument for the firing at `time`, ns."""

    def awaited(self, time: int) -> list[str]:
        """Names of the edges for which a firing at `time`, ns, waits. Safe from any thread."""
        return [queue.name for queue in self.queues if queue.watermark <= time]

    def relieve_backpressure(self, earliest: int, lag: int) -> None:
        """Let the senders of full edges go on, for the stage waits for another input.

        earliest: nothing fires before this time, ns; lag: see `Join.relieve_backpressure`.
        """
        for queue in self.queues:
            if len(queue.messages) >= queue.depth:
                self._relieve_backpressure(queue, earliest, lag)

    def discard_rest(self) -> None:
        """Discard the messages that no firing will get."""
        for queue in self.queues:
            queue.clear(self.column)

    def _relieve_backpressure(self, queue: InputQueue, earliest: int, lag: int) -> None:
        queue.exempt(earliest + lag)


class NewestInput(SampledInput):
    """`Latest`, or a feedback edge with `delay`: gives the newest message up to a time, again and again."""

    __slots__ = ("column", "delay", "held", "outlasts_deadline", "past", "queue", "timed")

    def __init__(self, queue: InputQueue, *, delay: int, timed: bool, initial: Message | None) -> None:
        """delay: firings back, 0 for `Latest`; timed: sample by capture time, not by arrival."""
        super().__init__((queue,))
        self.queue = queue
        self.delay = delay
        self.timed = timed
        self.held = initial
        self.outlasts_deadline = delay > 0
        self.column = UNMATCHED if delay else DROPPED
        self.past: deque[int] = deque([_BEFORE_ALL] * delay, maxlen=max(1, delay))

    def ready(self, time: int) -> bool:
        return not self.timed or self.queue.watermark > self._due(time)

    def sample(self, time: int) -> Message | None:
        """The newest message up to the firing at `time`, ns; older ones without a firing count as dropped."""
        due = self._due(time) if self.timed else END
        self.queue.supersede(due)
        if self.queue.messages and self.queue.messages[0].header.time <= due:
            self.held = self.queue.take()
        if self.delay:
            self.past.append(time)
        return self.held

    def awaited(self, time: int) -> list[str]:
        return [] if self.ready(time) else [self.queue.name]

    def _relieve_backpressure(self, queue: InputQueue, earliest: int, lag: int) -> None:
        if not self.delay:  # else the ledger would tell whether the edge was full
            queue.supersede(earliest)
        queue.exempt(earliest + lag)

    def _due(self, time: int) -> int:
        """Latest capture time, ns, to sample: of this firing, or of the one `delay` firings ago."""
        return self.past[0] if self.delay else time


class NearestInput(SampledInput):
    """`Nearest`: gives the message nearest to the firing, the earlier of two that are equally near.

    It is certain as soon as a message at or after the firing is there, or the watermark says that none comes
    which would be nearer. A message may be the nearest to several firings.
    """

    __slots__ = ("held", "queue", "tolerance")

    column = DROPPED

    def __init__(self, queue: InputQueue, *, tolerance: int) -> None:
        """tolerance: largest distance from the firing, ns."""
        super().__init__((queue,))
        self.queue = queue
        self.tolerance = tolerance
        self.held: Message | None = None
        """The message that the last firing got."""

    def ready(self, time: int) -> bool:
        self.queue.supersede(time)
        known = self._around(time)
        if known and known[-1].header.time >= time:
            return True
        away = min([time - message.header.time for message in known], default=self.tolerance + 1)
        return self.queue.watermark >= time + min(away, self.tolerance + 1)

    def sample(self, time: int) -> Message | None:
        """The nearest message, None if it lies beyond the tolerance; those it passes count as dropped."""
        self.queue.supersede(time)
        found = min(self._around(time), key=lambda m: abs(m.header.time - time), default=None)
        if found is None or abs(found.header.time - time) > self.tolerance:
            return None
        if found is not self.held:
            while self.queue.messages[0] is not found:
                self.queue.discard(DROPPED)
            self.held = self.queue.take()
        return found

    def _around(self, time: int) -> list[Message]:
        """The candidates for the nearest message, in order: the last before this time, and the next."""
        found = [] if self.held is None else [self.held]
        for message in self.queue.messages:
            found.append(message)
            if message.header.time >= time:
                break
        return found

    def _relieve_backpressure(self, queue: InputQueue, earliest: int, lag: int) -> None:
        queue.supersede(earliest)
        queue.exempt(earliest + lag)


class WindowInput(SampledInput):
    """`Window`: gives all messages since the last firing, of all its edges, in the order of capture times.

    If a live stage fires at its deadline, what comes late is in the next window. What comes after the last
    firing counts as unmatched.
    """

    __slots__ = ()

    def ready(self, time: int) -> bool:
        return all(queue.watermark > time for queue in self.queues)

    def sample(self, time: int) -> tuple[Message, ...]:
        found = []
        for queue in self.queues:
            messages = queue.messages
            while messages and messages[0].header.time <= time:
                found.append(queue.take())
        if len(self.queues) > 1:
            found.sort(key=_capture_time)
        return tuple(found)
