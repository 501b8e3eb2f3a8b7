"""The taps of one worker; on another host than the operator's, their messages travel over Zenoh."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection
from functools import partial
from queue import SimpleQueue

from followspot.context import Post
from followspot.control.dispatch import Handlers
from followspot.control.tapping import PlaceTaps, RemoveTaps, Tapping
from followspot.transport.keys import tap_key
from followspot.worker.scheduler import Scheduler
from followspot.worker.taps.port_taps import Tap, tap, taps_of
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

_Job = Callable[[], None]


class WorkerTaps:
    """Places and removes taps in a thread, so that imports, files and receivers do not hold up the stages.

    name: of the worker.
    """

    def __init__(
        self, name: str, scheduler: Scheduler, edge_factory: WorkerEdgeFactory, warn: Callable[[str], None]
    ) -> None:
        self._host = edge_factory.plan.host_of(name)
        self._scheduler = scheduler
        self._edge_factory = edge_factory
        self._warn = warn
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._detached: list[Tap] = []
        """Taps that are no longer at their ports, and whose sinks are to be closed."""

    @property
    def handlers(self) -> Handlers:
        """The orders that taps carry out."""
        return {
            PlaceTaps: lambda order: self.place(order.taps),
            RemoveTaps: lambda order: self._begin(partial(self._remove, order.taps)),
        }

    def place(self, tappings: Collection[Tapping]) -> None:
        """Begin to place taps."""
        self._begin(partial(self._place, tappings))

    def close(self) -> None:
        """Close all taps, so that their sinks complete their outputs, and place no new ones."""
        self._jobs.put(None)
        if self._thread is not None:
            self._thread.join()
        self._detach(tuple(taps_of(self._scheduler)))
        self._close_detached()

    def _begin(self, job: _Job) -> None:
        """Do a job after the earlier ones, and return at once."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="taps", daemon=True)
            self._thread.start()
        self._jobs.put(job)

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            job()

    def _place(self, tappings: Collection[Tapping]) -> None:
        try:
            tap(self._scheduler, tappings, self._post)
        except Exception as error:
            self._warn(f"taps cannot be made: {error}")

    def _remove(self, tappings: Collection[Tapping]) -> None:
        """Detach taps; their sinks are closed once no stage is at work, and so no sink."""
        self._detach([found for found in taps_of(self._scheduler) if found.tapping in tappings])
        self._scheduler.between_firings(partial(self._jobs.put, self._close_detached))

    def _detach(self, taps: Collection[Tap]) -> None:
        for found in taps:
            found.detach()
        self._detached += taps

    def _close_detached(self) -> None:
        while self._detached:
            self._detached.pop().close()

    def _post(self, tapping: Tapping) -> Post | None:
        session = self._edge_factory.zenoh.session
        if not self._host or session is None:
            return None
        from followspot.transport.zenoh.post import ZenohPost

        return ZenohPost(
            session, tap_key(self._edge_factory.zenoh.run, self._host, tapping.port, tapping.uses)
        )
