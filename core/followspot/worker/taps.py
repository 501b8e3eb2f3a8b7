"""The taps of one worker; on another host than the operator's, their messages travel over Zenoh."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable

from followspot.control.dispatch import Handlers
from followspot.control.tapping import PlaceTaps, Tapping
from followspot.stage import Post
from followspot.transport.keys import tap_key
from followspot.worker.edge_links import EdgeLinks
from followspot.worker.scheduler import Worker
from followspot.worker.tapping import close_taps, tap


class WorkerTaps:
    """Adds taps from a thread, so that imports and files do not hold up the stages; name: of the worker."""

    def __init__(self, name: str, worker: Worker, links: EdgeLinks, warn: Callable[[str], None]) -> None:
        self._host = links.plan.host_of(name)
        self._worker = worker
        self._links = links
        self._warn = warn
        self._one = threading.Lock()
        self._over = False

    @property
    def handlers(self) -> Handlers:
        """The orders that taps carry out."""
        return {PlaceTaps: lambda order: self.place(order.taps)}

    def place(self, tappings: Iterable[Tapping]) -> None:
        """Begin to add taps, and return at once."""
        threading.Thread(target=self._place, args=(tuple(tappings),), name="taps", daemon=True).start()

    def close(self) -> None:
        """Close all taps, and add no more."""
        with self._one:
            self._over = True
            close_taps(self._worker)

    def _place(self, tappings: Iterable[Tapping]) -> None:
        with self._one:
            if self._over:
                return
            try:
                tap(self._worker, tappings, self._post)
            except Exception as error:
                self._warn(f"taps cannot be made: {error}")

    def _post(self, tapping: Tapping) -> Post | None:
        session = self._links.session
        if not self._host or session is None:
            return None
        from followspot.transport.zenoh.post import ZenohPost

        return ZenohPost(session, tap_key(self._links.run, self._host, tapping.port, tapping.uses))
