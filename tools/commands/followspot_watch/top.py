"""`followspot top`: show the state of each stage and edge of a run, and renew it."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from followspot.cli.agent_options import network_of
from followspot.library.handle import LIMIT_MS, LOSSES, SOURCE_LOSSES, RunHandle, connected_run
from followspot.tables.terminal import blocks, grid, is_screen, line, plain
from followspot_watch.run_monitor import RunMonitor
from followspot_watch.screen import live_screen

if TYPE_CHECKING:
    from rich.console import RenderableType

_FIRST = 1.0
"""Seconds over which the first rates are taken."""
_LEAST = 0.5
"""Timeout of a request to the run at least, s."""
_ERROR = 100
"""Characters of an error that the report shows."""
BAD_STATES = ("old", "absent")
LASTING = 1.0
"""Seconds after which the report shows how long a state has lasted."""


def top(args: argparse.Namespace) -> int:
    """Show the run until it ends, or once if the output is no terminal. Returns the exit code."""
    with connected_run(args.run, network_of(args)) as run:
        picture = RunMonitor(run.outline())
        picture.take(run.status())
        try:
            if args.json or not is_screen(sys.stdout):
                time.sleep(_FIRST)
                picture.take(run.status())
                data = _data(run, picture)
                print(json.dumps(data) if args.json else text(data))
            elif _watch(run, picture, args.every):
                print("the run has ended")
        except KeyboardInterrupt:
            pass
    return 0


def _watch(run: RunHandle, picture: RunMonitor, every: float) -> bool:
    """Renew the tables on the terminal until all stages are over; True if the run ended before that.

    every: seconds between two tables.
    """
    pause = _FIRST
    with live_screen() as show:
        while True:
            time.sleep(pause)
            picture.renew(lambda: run.status(max(every, _LEAST)))
            if picture.ended:
                return True
            data = _data(run, picture)
            show(partial(report, data))
            if data["stages"] and all(stage["state"] == "over" for stage in data["stages"]):
                return False
            pause = every


def _data(run: RunHandle, picture: RunMonitor) -> dict[str, Any]:
    return {"run": run.run, "graph": run.graph, **picture.data()}


def text(data: dict[str, Any]) -> str:
    """The report as plain text."""
    return plain(report(data))


def report(data: dict[str, Any], most: int | None = None) -> RenderableType:
    """The tables of a run's figures, as `RunMonitor.data` gives them with its run and graph.

    most: rows of each table; None for all.
    """
    expected = f" of {data['expected']}" if data["expected"] else ""
    head = f"{data['graph']} ({data['run'][:8]}): {data['fired']}{expected} frames, {_rate(data)} per second"
    errors = [f"  {s['stage']}: {s['error'].splitlines()[0][:_ERROR]}" for s in data["stages"] if s["error"]]
    change = [line(f"a change waits for {data['change_awaits']}")] if data["change_awaits"] else []
    clocks = [line("clocks, offset added to the times of each host"), _clocks(data["clocks"])]
    return blocks(
        [line(head), *(line(fault, bad=True) for fault in data["faults"]), *change],
        [_stages(data["stages"][:most])],
        [_edges(data["edges"][:most])],
        _lost_at_source(data["edges"]),
        [_paths(data["paths"][:most])],
        clocks if data["clocks"] else [],
        _listed("last errors", errors),
        _listed("news", [f"  {news}" for news in data["news"]]),
    )


def _listed(title: str, lines: Sequence[str]) -> Sequence[RenderableType]:
    return [line(title), *map(line, lines)] if lines else []


def _stages(stages: Sequence[dict[str, Any]]) -> RenderableType:
    head = ("stage", "worker", "state", "on", "per second", "load", "fired", "skipped", "restarts")
    rows = []
    for s in stages:
        pace = (_rate(s), "-" if s["load"] is None else f"{100 * s['load']:.0f} %")
        counts = (str(s["fired"]), str(s["skipped"]), str(s["restarts"]))
        rows.append((s["stage"], s["worker"], _state(s), _waits(s), *pace, *counts))
    return grid(head, rows, [s["state"] in BAD_STATES for s in stages])


def _edges(edges: Sequence[dict[str, Any]]) -> RenderableType:
    head = ("edge", "kind", "per second", "produced", "away", "sent", "in flight", *LOSSES)
    rows = []
    for e in edges:
        counts = (str(e[name]) for name in ("produced", "away", "sent", "in_flight", *LOSSES))
        rows.append((f"{e['from']} -> {e['to']}", e["kind"], _rate(e), *counts))
    return grid(head, rows, [e["old"] for e in edges])


def _lost_at_source(edges: Sequence[dict[str, Any]]) -> Sequence[RenderableType]:
    """Sources whose devices lost frames; every edge of a port says the same."""
    lost = {e["from"]: tuple(str(e[name]) for name in SOURCE_LOSSES) for e in edges}
    rows = [(name, *counts) for name, counts in lost.items() if any(count != "0" for count in counts)]
    head = ("frames lost at the source", *(name.replace("_", " ") for name in SOURCE_LOSSES))
    return [grid(head, rows)] if rows else []


def _state(stage: dict[str, Any]) -> str:
    """State of a stage, and seconds since its worker answered or since it fired."""
    since = stage["idle_s"] if stage["age_s"] is None else stage["age_s"]
    lasting = since >= LASTING and stage["state"] != "over"
    return str(stage["state"]) + (f" {since:.0f} s" if lasting else "")


def _rate(figures: dict[str, Any]) -> str:
    return "-" if figures["rate"] is None else f"{figures['rate']:.1f}"


def _clocks(clocks: Sequence[dict[str, Any]]) -> RenderableType:
    head = ("host", "by the clock of", "offset ms", "round trip ms", "")
    rows = []
    for c in clocks:
        note = "" if c["exchanges"] else "not compared"
        note = "set it by NTP or PTP" if abs(c["offset_ms"]) >= LIMIT_MS else note
        times = f"{c['offset_ms']:+.3f}", f"{c['round_trip_ms']:.3f}"
        rows.append((c["host"] or "this host", c["reference"], *times, note))
    return grid(head, rows)


def _paths(paths: Sequence[dict[str, Any]]) -> RenderableType:
    rows = [(f"{p['origin']} -> {p['sink']}", f"{p['p50_ms']:.2f}", f"{p['p95_ms']:.2f}") for p in paths]
    return grid(("path", "p50 ms", "p95 ms"), rows, [p["old"] for p in paths])


def _waits(stage: dict[str, Any]) -> str:
    """The other end of the edge on which a stage waits: the sender, or the receiver if the edge is full."""
    if not stage["on"]:
        return ""
    ends = stage["on"][0].split(" -> ")
    more = f" +{len(stage['on']) - 1}" if len(stage["on"]) > 1 else ""
    return str(ends[stage["state"] == "sending"]) + more
