"""The sources of a worker: which of them sends next, and how their streams end."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from operator import attrgetter

from followspot.control.dispatch import Handlers
from followspot.control.worker_orders import EndSensors
from followspot.transport.token import END
from followspot.worker.hold import SourceHold
from followspot.worker.runners.live_source import LiveSourceRunner
from followspot.worker.runners.source import SourceRunner
from followspot.worker.runners.stage_runner import StageRunner

_LONGEST_REST_NS = 50_000_000
"""Longest time that a source which keeps a pace leaves to the stages, ns."""
_watermark = attrgetter("watermark")


class Sources:
    """The source runners of a worker, and the hold that pauses them."""

    def __init__(self) -> None:
        self.all: tuple[SourceRunner, ...] = ()
        self.live: tuple[LiveSourceRunner, ...] = ()
        self.hold = SourceHold()
        self._resting_until = END
        """When the first resting source goes on, as the last pull found it, ns of the monotonic clock."""

    @property
    def handlers(self) -> Handlers:
        """The orders that concern sources alone."""
        return {EndSensors: self._end_sensors, **self.hold.handlers}

    def arrange(self, runners: Sequence[StageRunner]) -> None:
        """Pull the sources among these from now on."""
        self.all = tuple(runner for runner in runners if isinstance(runner, SourceRunner))
        self.live = tuple(runner for runner in self.all if isinstance(runner, LiveSourceRunner))
        self.hold.sources = self.all

    def pull(self) -> bool:
        """Pull the source with the earliest watermark, and all that are as far; False if none did anything.

        While a source waits to send a message, none that is ahead of it goes on. After one has made a message
        that it keeps, the others wait for the next call: stages go first that have become ready meanwhile.
        """
        candidates = [s for s in self.all if not s.done and not self.hold.holds(s)]
        candidates.sort(key=_watermark)
        pulled, reached, now = False, END, time.monotonic_ns()
        self._resting_until = END
        for source in candidates:
            if source.watermark >= reached:
                break
            if source.interval and (until := self._rests_until(source)) > now:
                self._resting_until = min(self._resting_until, until)
                reached = min(reached, source.watermark + 1)
                continue
            source.blocked = not source.outputs.has_room()
            if source.blocked:
                continue
            kept = source.keeps
            if source.pull() or source.done:
                pulled, reached = True, min(reached, source.watermark)
            elif source.keeps and not self.hold.holds(source):
                if not kept:
                    return True
                reached = min(reached, source.watermark + 1)
        return pulled

    def due(self) -> Iterator[float]:
        """When those that keep a pace have their next message to send or to make, s, monotonic."""
        for source in self.all:
            if source.keeps and not source.done and not self.hold.holds(source):
                yield source.not_before / 1e9
        if self._resting_until < END:
            yield self._resting_until / 1e9

    def _rests_until(self, source: SourceRunner) -> int:
        """When a source may begin to make its next message, ns of the monotonic clock.

        Until then a source that keeps a pace leaves the cores to the stages that process its last message, in
        other workers too. It begins halfway to the next message, or earlier, so that all sources of this
        worker need no more than half of the time that is left.
        """
        if source.keeps or source.stopped or self.hold.holding:
            return 0
        making = sum(other.made_in for other in self.all if other.interval and not other.done)
        rest = min(source.interval // 2, source.interval - 2 * making, _LONGEST_REST_NS)
        return source.not_before + max(0, rest)

    def still(self) -> bool:
        """Whether no source of a recording will send anything as long as it is held."""
        return all(s.done or self.hold.holds(s) or s in self.live for s in self.all)

    def stop(self) -> None:
        """End all streams now."""
        self.hold.release()
        self.hold.set_free()
        for source in self.all:
            if not source.done:
                source.stop()

    def expected(self) -> int | None:
        """Messages that the longest source will yield; None if no source knows."""
        known = [n for n in (source.expected() for source in self.all) if n is not None]
        return max(known, default=None)

    def last_times(self) -> dict[str, int]:
        """Capture times of the last frames of a limited run, ns, of the sources that know them."""
        found = ((source.name, source.expected_last_time()) for source in self.all)
        return {name: time for name, time in found if time is not None}

    def _end_sensors(self, order: EndSensors) -> None:
        for source in self.all:
            if source.name in order.sensors and not source.done:
                source.end_after(order.time)
