"""`followspot hz`: how regularly ports of a run send, and what gets lost behind them."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from followspot.cli.agent_options import network_of
from followspot.cli.summary import table
from followspot.deploy.connect import connected_run
from followspot.deploy.run_handle import RunHandle
from followspot.deploy.status import RunStatus
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.plugins.registry import use_plugin_files
from followspot.runtime.ledger import LOSSES
from followspot.transport.zenoh_network import AGENT, LOOPBACK
from followspot_dashboard.meter import Rhythm
from followspot_watch.ear import Ear, HeardPort, chosen, listening
from followspot_watch.screen import screenful

SINK = "dashboard.meter"
_PERIOD = 0.5
"""Seconds between two tables on a terminal."""
_BEGINNING = 5.0
"""Seconds that it may take until a first message is measured: a busy worker begins to do so in its time."""


@dataclass(frozen=True)
class Pace:
    """One port.

    silent_s: since when nothing was told of it, s; dropped: messages that did not arrive, of all edges from
    it since the run began, those that no reader was there for included.
    """

    port: str
    rhythm: Rhythm | None
    silent_s: float
    dropped: int

    def data(self) -> dict[str, Any]:
        """JSON types; null where nothing was sent while it was looked at."""
        names = [name for name, _ in Rhythm.scalars]
        known = {name: getattr(self.rhythm, name) if self.rhythm else None for name in names}
        rounded = {n: round(v, 3) if isinstance(v, float) else v for n, v in known.items()}
        return {"port": self.port, **rounded, "silent_s": round(self.silent_s, 1), "dropped": self.dropped}


def hz(args: argparse.Namespace) -> int:
    """Measure for so many seconds and print; on a terminal until the run ends or Ctrl-C. Returns the code."""
    once = args.json or not sys.stdout.isatty()
    use_plugin_files(args.plugin_files)
    with connected_run(args.run, network_of(args, LOOPBACK, AGENT)) as run:
        measured = Measured(run, chosen(args.port, run))
        try:
            with listening(run, measured.ports, SINK, window=args.seconds) as ear:
                _measure(ear, measured, args.seconds if once else None)
        except KeyboardInterrupt:
            if not once:
                return 0
        paces = measured.paces()
    print(json.dumps([pace.data() for pace in paces]) if args.json else text(paces))
    return 0


class Measured:
    """What was told of the ports so far."""

    def __init__(self, run: RunHandle, heard: Sequence[HeardPort]) -> None:
        self.ports = [replace(port, type=Rhythm) for port in heard]
        self._run = run
        self._plan = run.plan()
        self._dropped: Mapping[str, int] = {}
        self._told: dict[str, tuple[Rhythm, float]] = {}
        self._since = time.monotonic()

    @property
    def begun(self) -> bool:
        """Whether anything was measured."""
        return bool(self._told)

    def take(self, port: str, rhythm: Rhythm) -> None:
        """A newer measurement."""
        self._told[port] = rhythm, time.monotonic()

    def paces(self) -> list[Pace]:
        """One a port, in the order of the graph."""
        now = time.monotonic()
        with suppress(FollowspotError):  # it has ended, and the last counts stand
            self._dropped = dropped(self._plan, self._run.status())
        found = []
        for port in self.ports:
            rhythm, at = self._told.get(port.name, (None, self._since))
            found.append(Pace(port.name, rhythm, now - at, self._dropped.get(port.name, 0)))
        return found


def dropped(plan: Plan, status: RunStatus) -> dict[str, int]:
    """Messages of each port that did not arrive, whatever the reason, summed over its edges."""
    found: dict[str, int] = {}
    for edge, count in status.edges(plan):
        port = f"{edge.from_stage}.{edge.from_port}"
        found[port] = found.get(port, 0) + sum(getattr(count, name) for name in ("away", *LOSSES))
    return found


def text(paces: Sequence[Pace]) -> str:
    """A table; a port that sent nothing has none but its losses."""
    head = ("port", "per second", "mean ms", "jitter ms", "p95 ms", "worst ms", "messages", "dropped", "")
    return table(head, [_row(pace) for pace in paces])


def _row(pace: Pace) -> tuple[str, ...]:
    r = pace.rhythm
    silent = f"silent for {pace.silent_s:.0f} s" if pace.silent_s >= 2.0 else ""
    if r is None:
        return (pace.port, *("-",) * 5, "0", str(pace.dropped), silent)
    gaps = (r.mean_ms, r.jitter_ms, r.p95_ms, r.worst_ms)
    return (
        pace.port,
        f"{r.rate:.1f}",
        *(f"{gap:.2f}" for gap in gaps),
        str(r.count),
        str(pace.dropped),
        silent,
    )


def _measure(ear: Ear, measured: Measured, seconds: float | None) -> None:
    """For the time from the first measurement on, or until the run ends; without a time, with tables."""
    end = None if seconds is None else time.monotonic() + _BEGINNING + seconds
    for heard in ear.heard(_PERIOD if seconds is None else min(_PERIOD, seconds)):
        if heard is not None:
            port, message = heard
            assert isinstance(message, Rhythm)
            if seconds is not None and not measured.begun:
                end = time.monotonic() + seconds
            measured.take(port, message)
        elif end is None:
            print(screenful(text(measured.paces())), flush=True)
        if end is not None and time.monotonic() >= end:
            return
