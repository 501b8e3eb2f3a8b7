"""The handle that scripts and notebooks hold on a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from followspot.closing import Closing
from followspot.control.dispatch import Ask
from followspot.errors import FollowspotError
from followspot.library.overlay import save_overlay
from followspot.library.plan_settings import as_tuple
from followspot.library.subscription import M, Subscription
from followspot.library.tap_subscriptions import TapSubscriptions
from followspot.operator.change_outcome import MoveOutcome
from followspot.operator.run_handle import RunHandle
from followspot.tables.html import html_table


class ScriptHandle(RunHandle, Closing):
    """A run whose ports can be subscribed to, and which shows its workers in Jupyter."""

    def __init__(
        self,
        run: str,
        graph: str,
        ask: Ask,
        pid: int | None = None,
        failure: Callable[[], Exception | None] = lambda: None,
    ) -> None:
        """failure: returns the error of the run, which loops over ports raise; the others: see
        `RunHandle`.
        """
        super().__init__(run, graph, ask, pid)
        self._taps = TapSubscriptions(self, failure)

    def subscribe(self, port: str, kind: type[M]) -> Subscription[M]:
        """``self[port]`` for type checkers and editors: a subscription to messages of this type.

        kind: for example `followspot.tracking.Tracks`. Raises FollowspotError if the port gives other
        messages, or if there is no such port.
        """
        found = self[port]
        other = sorted(given.__name__ for given in found.types if not issubclass(given, kind))
        if other:
            raise FollowspotError(f"{port} gives {', '.join(other)}, not {kind.__name__}")
        return found

    def __getitem__(self, port: str) -> Subscription[Any]:
        """The newest messages of a port from now on; `dropped` counts the rest.

        port: STAGE.PORT, or a shorter name as `ports=` of `run` takes it. Raises FollowspotError.
        """
        return self._taps.subscription(port)

    def move(self, stages: str | Sequence[str], place: str) -> MoveOutcome:
        """Move stages of a live run, one or several, to another worker, or to a host in reach of the run.

        Workers whose stages or kinds of edges change restart from the state of their stages. Messages in
        flight to and from them are lost and counted.
        """
        return super().move(as_tuple("stages", stages), place)

    def save(self, path: str | Path) -> tuple[str, ...]:
        """Save what was changed as a new graph file that extends the run's own; the stages that it names.

        path: NAME.yaml. Raises FollowspotError if nothing was, or an overlay cannot say it.
        """
        return save_overlay(self, path)

    def close(self) -> None:
        """End the subscriptions; the run goes on."""
        self._taps.close()

    def __repr__(self) -> str:
        return f"<run {self.label}: {self._state()}>"

    def _repr_html_(self) -> str:
        try:
            workers = self.status().workers
        except FollowspotError:
            return html_table(("run", "state"), [(self.label, self._state())])
        rows = [
            (worker.name, worker.host or "this host", worker.phase, str(worker.fired), str(worker.restarts))
            for worker in workers
        ]
        return html_table(("worker", "host", "phase", "frames", "restarts"), rows, self.label)

    def _state(self) -> str:
        return "ended" if self.over() else "running"
