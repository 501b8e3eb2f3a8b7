"""`followspot top`: what each stage and edge of a run is doing, as a table that renews itself."""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

from followspot.cli.agent_options import network_of
from followspot.cli.summary import table
from followspot.deploy.clocks.status import LIMIT_MS
from followspot.errors import FollowspotError
from followspot.transport.zenoh_network import AGENT, LOOPBACK
from followspot_watch.picture_of_run import RunPicture
from followspot_watch.runs import looking
from followspot_watch.screen import screenful

_FIRST = 1.0
"""Seconds over which the first rates are taken."""
_LOSSES = ("dropped", "late", "unmatched", "invalid", "lost")
_ERROR = 100
"""Characters of an error that are shown."""


def top(args: argparse.Namespace) -> int:
    """Show the run until it ends, or once where the output is no terminal. Returns the exit code."""
    with looking(args.run, network_of(args, LOOPBACK, AGENT)) as look:
        picture = RunPicture(look.plan)
        picture.take(look.status())
        pause, once = _FIRST, args.json or not sys.stdout.isatty()
        try:
            while True:
                time.sleep(pause)
                picture.take(look.status())
                data = {"run": look.run, "graph": look.plan.graph, **picture.data()}
                if args.json:
                    print(json.dumps({name: value for name, value in data.items() if name != "type"}))
                else:
                    print(text(data) if once else screenful(text(data)), flush=True)
                if once or _over(data):
                    return 0
                pause = args.every
        except KeyboardInterrupt:
            return 0
        except FollowspotError:
            if once:
                raise
            print("the run has ended")
            return 0


def text(data: dict[str, Any]) -> str:
    """The tables of a run's figures, as `RunPicture.data` gives them with its run and graph."""
    expected = f" of {data['expected']}" if data["expected"] else ""
    head = f"{data['graph']} ({data['run'][:8]}): {data['fired']}{expected} frames"
    parts = [f"{head}, {data['rate']:.1f} per second", _stages(data), _edges(data), _paths(data)]
    errors = [f"  {s['stage']}: {s['error'].splitlines()[0][:_ERROR]}" for s in data["stages"] if s["error"]]
    parts += ["clocks, what is added to the times of each host\n" + _clocks(data)] if data["clocks"] else []
    parts += ["last errors\n" + "\n".join(errors)] if errors else []
    parts += ["news\n" + "\n".join(f"  {line}" for line in data["news"])] if data["news"] else []
    return "\n\n".join(parts)


def _stages(data: dict[str, Any]) -> str:
    head = ("stage", "worker", "state", "on", "per second", "load", "fired", "skipped", "restarts")
    rows = []
    for s in data["stages"]:
        pace = (f"{s['rate']:.1f}", f"{100 * s['load']:.0f} %")
        counts = (str(s["fired"]), str(s["skipped"]), str(s["restarts"]))
        rows.append((s["stage"], s["worker"], s["state"], _waits(s), *pace, *counts))
    return table(head, rows)


def _edges(data: dict[str, Any]) -> str:
    rows = []
    for e in data["edges"]:
        counts = (str(e[name]) for name in ("sent", "in_flight", *_LOSSES))
        rows.append((f"{e['from']} -> {e['to']}", e["kind"], f"{e['rate']:.1f}", *counts))
    return table(("edge", "kind", "per second", "sent", "in flight", *_LOSSES), rows)


def _clocks(data: dict[str, Any]) -> str:
    head = ("host", "by the clock of", "offset ms", "round trip ms", "")
    rows = []
    for c in data["clocks"]:
        note = "" if c["exchanges"] else "not compared"
        note = "set it by NTP or PTP" if abs(c["offset_ms"]) >= LIMIT_MS else note
        times = f"{c['offset_ms']:+.3f}", f"{c['round_trip_ms']:.3f}"
        rows.append((c["host"] or "this host", c["reference"], *times, note))
    return table(head, rows)


def _paths(data: dict[str, Any]) -> str:
    rows = [
        (f"{p['origin']} -> {p['sink']}", f"{p['p50_ms']:.2f}", f"{p['p95_ms']:.2f}") for p in data["paths"]
    ]
    return table(("path", "p50 ms", "p95 ms"), rows)


def _waits(stage: dict[str, Any]) -> str:
    """On whom a stage waits: who sends to it, or who takes what it sends."""
    if not stage["on"]:
        return ""
    ends = stage["on"][0].split(" -> ")
    more = f" +{len(stage['on']) - 1}" if len(stage["on"]) > 1 else ""
    return str(ends[stage["state"] == "sending"]) + more


def _over(data: dict[str, Any]) -> bool:
    return bool(data["stages"]) and all(stage["state"] == "over" for stage in data["stages"])
