"""The hold of a worker's sources: a paused replay sends nothing until its operator lets it go on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from followspot.control.dispatch import Handlers
from followspot.control.stage_status import StageStatus
from followspot.control.worker_orders import HoldSources
from followspot.transport.token import END
from followspot.worker.runners.live_source import LiveSourceRunner
from followspot.worker.runners.source import SourceRunner
from followspot.worker.runners.stage_runner import StageRunner


class SourceHold:
    """Decides which sources of a worker send nothing: the operator holds them, or they come to rest."""

    def __init__(self) -> None:
        self.sources: Sequence[SourceRunner] = ()
        self.order: HoldSources | None = None
        """The order that holds the sources, None if they are free."""
        self._aligned = False
        """Whether sources of recordings hold at one capture time while the worker comes to rest."""
        self._frozen = False
        """Whether live sources hold, too."""
        self._hold_at = 0
        """Messages of the source that the order names, after which it holds."""

    @property
    def handlers(self) -> Handlers:
        """The orders to hold sources and to let them go on."""
        return {HoldSources: self._carry_out}

    def holds(self, source: SourceRunner) -> bool:
        """True if this source sends nothing now."""
        order = self.order
        if self._aligned:  # even if paused: a source that is behind sends what is missing
            return self._frozen if isinstance(source, LiveSourceRunner) else source.at_limit
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

    @property
    def aligned(self) -> bool:
        """Whether sources hold so that the graph may change."""
        return self._aligned

    @property
    def newest(self) -> int:
        """The newest capture time, ns, that a source has sent which goes on; -1 for none."""
        return max((source.watermark for source in self._replayed()), default=-1)

    def freeze(self) -> None:
        """Hold each source where it is. Live devices go on; frames beyond their depth are dropped."""
        for source in self._replayed():
            source.until = source.watermark
        self._aligned = self._frozen = True

    def align(self, until: int) -> None:
        """Hold each source of a recording after this capture time, ns.

        It is the newest of any source, and the window in which joins match it: so no source has sent a part
        of what belongs together.
        """
        for source in self._replayed():
            source.until = until
        self._aligned = True

    def _replayed(self) -> list[SourceRunner]:
        return [s for s in self.sources if not (s.done or isinstance(s, LiveSourceRunner))]

    def set_free(self) -> None:
        """Hold sources only as the operator says."""
        for source in self.sources:
            source.until = END
        self._aligned = self._frozen = False

    def release(self) -> None:
        """Let all sources go on."""
        self.order = None

    def _carry_out(self, order: HoldSources) -> None:
        if order.held and (self.order is None or self.order.id != order.id):
            yielded = (source.yielded for source in self.sources if source.name == order.source)
            self._hold_at = sum(yielded) + order.count
        self.order = order if order.held else None
