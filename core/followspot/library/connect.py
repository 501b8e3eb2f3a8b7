"""A script's handle on a run of another process, or under agents."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from followspot.library.plan_settings import as_tuple, check_type
from followspot.library.script_handle import ScriptHandle
from followspot.operator.connect import connected_run
from followspot.plugins.registry import use_plugin_files
from followspot.transport.zenoh.network import Network


class ConnectedRun(ScriptHandle):
    """A run of another process, or under agents. Closing the handle does not end the run."""

    def __init__(self, wanted: str | None, network: Network | None) -> None:
        """Raises FollowspotError if there is no such run, or several."""
        self._stack = ExitStack()
        found = self._stack.enter_context(connected_run(wanted, network))
        super().__init__(found.run, found.graph, found.ask, found.pid)

    def close(self) -> None:
        """End the subscriptions and the connection; the run goes on."""
        super().close()
        self._stack.close()


def connect(
    run: str | None = None,
    *,
    network: Network | None = None,
    plugin_files: str | Path | Sequence[str | Path] = (),
) -> ConnectedRun:
    """A handle on a run that goes on: on this machine, else under agents that `network` leads to.

    run: the graph's name, the beginning of the run's, or the process id of its operator; None if there is
    one run; plugin_files: files with the stages and message types that agents have loaded from files. Raises
    FollowspotError if there is no such run, or several.
    """
    check_type("run", run, str | None, "give its name, or the beginning of it")
    use_plugin_files([str(Path(file).absolute()) for file in as_tuple("plugin_files", plugin_files)])
    return ConnectedRun(run, network)
