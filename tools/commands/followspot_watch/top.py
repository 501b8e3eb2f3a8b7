"""`followspot top`: what each stage and edge of a run is doing, as a table that renews itself."""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

from followspot.cli.agent_options import network_of
from followspot.library.handle import LIMIT_MS, LOSSES, connected_run
from followspot.tables import table
from followspot_watch.picture_of_run import RunPicture
from followspot_watch.screen import BAD, marked, screenful

_FIRST = 1.0
"""Seconds over which the first rates are taken."""
_LEAST = 0.5
"""Seconds for the run to answer, at least."""
_ERROR = 100
"""Characters of an error that are shown."""
BAD_STATES = ("old", "absent")
LASTING = 1.0
"""Seconds from which on it is told how long a state has lasted."""


def top(args: argparse.Namespace) -> int:
    """Show the run until it ends, or once where the output is no terminal. Returns the exit code."""
    with connected_run(args.run, network_of(args)) as run:
        picture = RunPicture(run.plan())
        picture.take(run.status())
        pause, once = _FIRST, args.json or not sys.stdout.isatty()
        try:
            while True:
                time.sleep(pause)
                if once:
                    picture.take(run.status())
                else:
                    picture.renew(lambda: run.status(max(args.every, _LEAST)))
                if picture.ended:
                    print("the run has ended")
                    return 0
                data = {"run": run.run, "graph": run.graph, **picture.data()}
                if args.json:
                    print(json.dumps({name: value for name, value in data.items() if name != "type"}))
                else:
                    print(text(data) if once else screenful(text(data)), flush=True)
                if once or _over(data):
                    return 0
                pause = args.every
        except KeyboardInterrupt:
            return 0


def text(data: dict[str, Any]) -> str:
    """The tables of a run's figures, as `RunPicture.data` gives them with its run and graph."""
    expected = f" of {data['expected']}" if data["expected"] else ""
    head = f"{data['graph']} ({data['run'][:8]}): {data['fired']}{expected} frames, {_rate(data)} per second"
    head = "\n".join([head, *(f"{BAD} {line}" for line in data["faults"])])
    parts = [head, _stages(data), _edges(data), _paths(data)]
    errors = [f"  {s['stage']}: {s['error'].splitlines()[0][:_ERROR]}" for s in data["stages"] if s["error"]]
    parts += ["clocks, what is added to the times of each host\n" + _clocks(data)] if data["clocks"] else []
    parts += ["last errors\n" + "\n".join(errors)] if errors else []
    parts += ["news\n" + "\n".join(f"  {line}" for line in data["news"])] if data["news"] else []
    return "\n\n".join(parts)


def _stages(data: dict[str, Any]) -> str:
    head = ("stage", "worker", "state", "on", "per second", "load", "fired", "skipped", "restarts")
    rows = []
    for s in data["stages"]:
        pace = (_rate(s), "-" if s["load"] is None else f"{100 * s['load']:.0f} %")
        counts = (str(s["fired"]), str(s["skipped"]), str(s["restarts"]))
        rows.append((s["stage"], s["worker"], _state(s), _waits(s), *pace, *counts))
    return marked(table(head, rows), [s["state"] in BAD_STATES for s in data["stages"]])


def _edges(data: dict[str, Any]) -> str:
    rows = []
    for e in data["edges"]:
        counts = (str(e[name]) for name in ("produced", "away", "sent", "in_flight", *LOSSES))
        rows.append((f"{e['from']} -> {e['to']}", e["kind"], _rate(e), *counts))
    text = table(("edge", "kind", "per second", "produced", "away", "sent", "in flight", *LOSSES), rows)
    return marked(text, [e["old"] for e in data["edges"]])


def _state(stage: dict[str, Any]) -> str:
    """What a stage is doing, and since when: nobody has heard of it, or it has not fired."""
    since = stage["idle_s"] if stage["age_s"] is None else stage["age_s"]
    lasting = since >= LASTING and stage["state"] != "over"
    return str(stage["state"]) + (f" {since:.0f} s" if lasting else "")


def _rate(figures: dict[str, Any]) -> str:
    return "-" if figures["rate"] is None else f"{figures['rate']:.1f}"


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
    return marked(table(("path", "p50 ms", "p95 ms"), rows), [p["old"] for p in data["paths"]])


def _waits(stage: dict[str, Any]) -> str:
    """On whom a stage waits: who sends to it, or who takes what it sends."""
    if not stage["on"]:
        return ""
    ends = stage["on"][0].split(" -> ")
    more = f" +{len(stage['on']) - 1}" if len(stage["on"]) > 1 else ""
    return str(ends[stage["state"] == "sending"]) + more


def _over(data: dict[str, Any]) -> bool:
    return bool(data["stages"]) and all(stage["state"] == "over" for stage in data["stages"])
