"""A run that goes on elsewhere, held by a script."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from followspot.library.subscription import Subscription
from followspot.library.tapped import TappedPorts
from followspot.operator.connect import connected_run
from followspot.operator.run_handle import RunHandle
from followspot.plugins.registry import use_plugin_files
from followspot.transport.zenoh.network import Network


class ConnectedRun(RunHandle):
    """A run of another process, or under agents. Closing it leaves the run to itself."""

    def __init__(self, wanted: str | None, network: Network | None) -> None:
        """Raises FollowspotError if there is no such run, or several."""
        self._stack = ExitStack()
        found = self._stack.enter_context(connected_run(wanted, network))
        super().__init__(found.run, found.graph, found.ask, found.pid)
        self._tapped = TappedPorts(self)
        self._stack.callback(self._tapped.close)

    def __getitem__(self, port: str) -> Subscription:
        """The newest messages of a port from now on; `dropped` counts the rest.

        port: STAGE.PORT, or a shorter name as `ports=` of `run` takes it. Raises FollowspotError.
        """
        return self._tapped.subscription(port)

    def close(self) -> None:
        """Let go of the run; it goes on."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def connect(
    run: str | None = None, *, network: Network | None = None, plugin_files: Sequence[str | Path] = ()
) -> ConnectedRun:
    """A handle on a run that goes on: on this machine, else under agents that `network` leads to.

    run: the graph's name, the beginning of the run's, or the process id of its operator; None if there is
    one run; plugin_files: with the stages and messages that agents have from files of theirs. Raises
    FollowspotError if there is no such run, or several.
    """
    use_plugin_files([str(Path(file).absolute()) for file in plugin_files])
    return ConnectedRun(run, network)
