"""Looking at ports of a graph that runs: sinks that are called with every message, beside the graph.

A tap has no edge: it neither fires nor counts, and nothing waits for it. One that fails is taken away.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from followspot.errors import FollowspotError
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.ports import ports
from followspot.runtime.outlet import Outlet
from followspot.runtime.worker import Worker
from followspot.stage import Post, Stage


@dataclass(frozen=True)
class Tapping:
    """port: STAGE.PORT that is looked at; uses, params: the sink that gets its messages."""

    port: str
    uses: str
    params: Mapping[str, Any]


class Tap:
    """One sink at one outlet; one that raises EOFError has nobody left to tell."""

    def __init__(self, tapping: Tapping, outlet: Outlet, stage: Stage) -> None:
        self.tapping = tapping
        self._outlet = outlet
        self._stage = stage

    def __call__(self, message: Message) -> None:
        """Hand the message to the sink; whatever it raises ends there."""
        try:
            self._stage.process(message)
        except Exception as error:
            self.close()
            if not isinstance(error, EOFError):
                self._stage.context.warn(f"a tap failed and was taken away: {error!r}")

    def close(self) -> None:
        """Look no more."""
        self._outlet.untap(self)
        self._stage.close()


def check_taps(tappings: Iterable[Tapping]) -> None:
    """Raises FollowspotError where a stage does not say of itself that it may be put at a port so."""
    for tapping in tappings:
        kind = load_stage(tapping.uses)
        if not kind.tap or ports(kind).outputs:
            raise FollowspotError(
                f"{tapping.uses} cannot look at {tapping.port} while the graph runs: it is no tap; "
                "a sink that other programs need stands in the graph"
            )


def close_taps(worker: Worker) -> None:
    """Let every sink that looks at the worker's ports complete what it does; the last thing in its life."""
    for cell in worker.cells:
        for _, outlet in cell.outlets:
            for found in outlet.taps:
                if isinstance(found, Tap):
                    found.close()


def tap(
    worker: Worker, tappings: Iterable[Tapping], post: Callable[[Tapping], Post | None] = lambda tapping: None
) -> None:
    """Look at those of the ports that the worker has, once; safe from any thread. Raises what sinks raise.

    post: the way of a tap to those who look on from other hosts.
    """
    outlets = {
        f"{cell.name}.{port}": (cell, outlet) for cell in worker.cells for port, outlet in cell.outlets
    }
    tappings = tuple(tappings)
    check_taps(tappings)
    for tapping in tappings:
        cell, outlet = outlets.get(tapping.port, (None, None))
        if cell is None or outlet is None or tapping in _tappings(outlet):
            continue
        context = replace(cell.stage.context, post=post(tapping))
        stage = load_stage(tapping.uses)(context, **tapping.params)
        stage.setup()
        outlet.tap(Tap(tapping, outlet, stage))


def _tappings(outlet: Outlet) -> list[Tapping]:
    return [tap.tapping for tap in outlet.taps if isinstance(tap, Tap)]
