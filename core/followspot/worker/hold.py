"""The hold of a worker's sources: a paused replay sends nothing until its operator lets it go on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from followspot.control.dispatch import Handlers
from followspot.control.stage_status import StageStatus
from followspot.control.worker_orders import HoldSources
from followspot.transport.token import END
from followspot.worker.live_source import LiveSourceRunner
from followspot.worker.source import SourceRunner
from followspot.worker.stage_runner import StageRunner


class SourceHold:
    """Decides which sources of a worker send nothing: the operator holds them, or they come to rest."""

    def __init__(self) -> None:
        self.sources: Sequence[SourceRunner] = ()
        self.order: HoldSources | None = None
        """The order that holds the sources, None if they are free."""
        self._aligned = False
        """Whether sources hold at one capture time while the worker comes to rest."""
        self._hold_at = 0
        """Messages of the source that the order names, after which it holds."""

    @property
    def handlers(self) -> Handlers:
        """The orders to hold sources and to let them go on."""
        return {HoldSources: self._obey}

    def holds(self, source: SourceRunner) -> bool:
        """True if this source sends nothing now."""
        order = self.order
        if self._aligned:  # even if paused: a source that is behind sends what is missing
            return isinstance(source, LiveSourceRunner) or source.at_limit
        if order is None:
            return False
        if source.name == order.source:
            return source.yielded >= self._hold_at
        here = (other.watermark for other in self.sources if other.name == order.source)
        return source.watermark >= max(here, default=order.until)

    def shown(self, runner: StageRunner, status: StageStatus) -> StageStatus:
        """The status; that of a source with its capture time, and whether it is paused. For any thread."""
        if not isinstance(runner, SourceRunner):
            return status
        order = self.order
        if runner.done or order is None or not self.holds(runner):
            return replace(status, time=runner.watermark if runner.watermark < END else -1)
        return replace(status, state="paused", on=(), time=runner.watermark, hold=order.id)

    @property
    def holding(self) -> bool:
        """True if anything holds sources."""
        return self.order is not None or self._aligned

    def align(self, window: int) -> None:
        """Hold each source after the newest capture time of any and the window, ns, in which joins match it.

        So no source has sent a part of what belongs together. Live sources hold at once.
        """
        replayed = [s for s in self.sources if not (s.done or isinstance(s, LiveSourceRunner))]
        newest = max((source.watermark for source in replayed), default=-1)
        for source in replayed:
            source.until = newest + window
        self._aligned = True

    def set_free(self) -> None:
        """Hold sources only as the operator says."""
        for source in self.sources:
            source.until = END
        self._aligned = False

    def release(self) -> None:
        """Let all sources go on."""
        self.order = None

    def _obey(self, order: HoldSources) -> None:
        if order.held and (self.order is None or self.order.id != order.id):
            yielded = (source.yielded for source in self.sources if source.name == order.source)
            self._hold_at = sum(yielded) + order.count
        self.order = order if order.held else None
