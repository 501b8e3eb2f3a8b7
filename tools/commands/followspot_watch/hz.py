"""`followspot hz`: measure the rate and the gaps of ports of a run, and count their losses."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from followspot.cli.agent_options import network_of
from followspot.library.handle import LOSSES, RunHandle, connected_run, is_stale
from followspot.messages import Message
from followspot.plugins.registry import use_plugin_files
from followspot.tables.terminal import blocks, grid, is_screen, line, plain
from followspot_dashboard.meter import Rhythm
from followspot_watch.run_monitor import RunMonitor
from followspot_watch.screen import live_screen
from followspot_watch.tap_subscriber import TapSubscriber, tapped_ports

if TYPE_CHECKING:
    from rich.console import RenderableType

SINK = "dashboard.meter"
SILENCE = 2.0
"""Seconds without a measurement after which a port counts as silent."""
_PERIOD = 0.5
"""Seconds between two tables on a terminal."""
_BEGINNING = 5.0
"""Seconds until the first measurement at most; a busy worker needs some time to place a tap."""


@dataclass(frozen=True)
class Pace:
    """The measurement of one port.

    silent_s: seconds since the last measurement; dropped: messages lost on all edges from the port since the
    run began, with those that no reader was connected for; stale: "absent" or "old" if the worker of the
    stage is silent, too.
    """

    port: str
    measured: Rhythm | None
    silent_s: float
    dropped: int
    stale: str = ""

    @property
    def rhythm(self) -> Rhythm | None:
        """The measurement; None after a silence that is far longer than the usual gap."""
        usual = 0.0 if self.measured is None else self.measured.worst_ms / 1000.0
        return None if self.stale or self.silent_s > max(SILENCE, 3.0 * usual) else self.measured

    def data(self) -> dict[str, Any]:
        """In JSON types; null if the port sent nothing while it was measured, or nothing lately."""
        names = [name for name, _ in Rhythm.scalars]
        known = {name: getattr(self.rhythm, name) if self.rhythm else None for name in names}
        rounded = {n: round(v, 3) if isinstance(v, float) else v for n, v in known.items()}
        state = {"silent_s": round(self.silent_s, 1), "stale": self.stale}
        return {"port": self.port, **rounded, **state, "dropped": self.dropped}


def hz(args: argparse.Namespace) -> int:
    """Measure for so many seconds and print; on a terminal until the run ends or Ctrl-C. Returns the code."""
    use_plugin_files(args.plugin_files)
    with connected_run(args.run, network_of(args)) as run:
        measured = Measured(run, tapped_ports(args.port, run))
        with TapSubscriber(run, measured.ports, SINK, window=args.seconds) as subscriber:
            if not args.json and is_screen(sys.stdout):
                _watch(subscriber, measured)
                return 0
            with suppress(KeyboardInterrupt):
                _measure(subscriber, measured, args.seconds)
        paces = measured.paces()
    print(json.dumps([pace.data() for pace in paces]) if args.json else text(paces, measured.faults()))
    return 0


class Measured:
    """The measurements of all ports so far."""

    def __init__(self, run: RunHandle, ports: Iterable[str]) -> None:
        self.ports: dict[str, type[Message]] = dict.fromkeys(ports, Rhythm)
        self._run = run
        self._picture = RunMonitor(run.plan())
        self._picture.take(run.status())
        self._measurements: dict[str, tuple[Rhythm, float]] = {}
        self._since = time.monotonic()

    @property
    def begun(self) -> bool:
        """Whether there is a measurement."""
        return bool(self._measurements)

    def take(self, port: str, rhythm: Message) -> None:
        """Keep a newer measurement."""
        assert isinstance(rhythm, Rhythm)
        self._measurements[port] = rhythm, time.monotonic()

    def paces(self) -> list[Pace]:
        """One for each port, in the order of the graph."""
        now = time.monotonic()
        self._picture.renew(lambda: self._run.status(_PERIOD))
        stale = {s.stage: s.state for worker, s in self._picture.stages() if is_stale(worker)}
        lost = dropped(self._picture)
        found = []
        for port in self.ports:
            rhythm, at = self._measurements.get(port, (None, self._since))
            stage = port.rpartition(".")[0]
            found.append(Pace(port, rhythm, now - at, lost.get(port, 0), stale.get(stage, "")))
        return found

    def faults(self) -> Sequence[str]:
        """A line for each host or worker that is absent or silent."""
        return self._picture.faults()


def dropped(picture: RunMonitor) -> dict[str, int]:
    """Messages of each port that were lost for any reason, summed over its edges."""
    found: dict[str, int] = {}
    for edge, count in picture.edges():
        port = f"{edge.from_stage}.{edge.from_port}"
        found[port] = found.get(port, 0) + sum(getattr(count, name) for name in ("away", *LOSSES))
    return found


def text(paces: Sequence[Pace], faults: Sequence[str] = ()) -> str:
    """The report as plain text."""
    return plain(report(paces, faults))


def report(paces: Sequence[Pace], faults: Sequence[str] = (), most: int | None = None) -> RenderableType:
    """Faults, and a table of ports; if a port sent nothing, its row has only its losses.

    most: rows of the table; None for all.
    """
    head = ("port", "per second", "mean ms", "jitter ms", "p95 ms", "worst ms", "messages", "dropped", "")
    paces = paces[:most]
    ports = grid(head, [_row(pace) for pace in paces], [bool(pace.stale) for pace in paces])
    return blocks([*(line(fault, bad=True) for fault in faults), ports])


def _row(pace: Pace) -> tuple[str, ...]:
    r = pace.rhythm
    problems = (pace.stale, f"silent for {pace.silent_s:.0f} s" if pace.silent_s >= SILENCE else "")
    silent = ", ".join(word for word in problems if word)
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


def _measure(subscriber: TapSubscriber, measured: Measured, seconds: float) -> None:
    """Measure for a time, s, that begins with the first measurement, or until the run ends."""
    end = time.monotonic() + _BEGINNING + seconds
    for received in subscriber.messages(min(_PERIOD, seconds)):
        if received is not None:
            if not measured.begun:
                end = time.monotonic() + seconds
            measured.take(*received)
        if time.monotonic() >= end:
            return


def _watch(subscriber: TapSubscriber, measured: Measured) -> None:
    """Renew the table on the terminal until the run ends or Ctrl-C."""
    with suppress(KeyboardInterrupt), live_screen() as show:
        for received in subscriber.messages(_PERIOD):
            if received is not None:
                measured.take(*received)
            else:
                show(partial(report, measured.paces(), measured.faults()))
