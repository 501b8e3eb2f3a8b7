"""Inflict random faults on a live run on several hosts; check recovery and the ledger.

    python tools/soak.py                          200 faults
    python tools/soak.py --faults 8 --seed 3      a short one
    python tools/soak.py --only "link down" "worker killed"

Three hosts and a router are network namespaces on this machine, so root is needed. Each host has two live
cameras of the simulated room with their detectors beside them; graphs/glowballs.yaml tracks at the desk. A
seventh camera ends, like a camera file. After each fault every worker must be at work, all six cameras used
together, and each target that a colour and an infrared camera see tracked within 15 cm of the truth, all
within --within seconds. The run must report a process that dies, hangs or is cut off within --notice seconds.
At the end every message must be accounted for, memory must not have grown, and no process or shared memory
may be left. All stages keep journals: they must agree with the ledger, except for the message that a killed
process was working on. No status may show impossible values. Exit code 1 if one of these checks fails.
"""

from __future__ import annotations

import argparse
import json
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

from scripting import options_of
from soaking.room import CAMERAS
from soaking.show import (
    FAULTS,
    SIDES,
    UNSEEN,
    Hosts,
    Journals,
    Show,
    descendants,
    disagreements,
    journals_of,
    unused_memory,
)

_RIGHT = 0.15
"""Largest error of a target that counts as tracked, m."""
_FRAMES = 3
"""Frames in a row that must be right."""
_FOREVER = 60.0
"""Seconds after which nothing is expected to come back any more."""
_UNNOTICED = 10.0
"""Seconds to wait for a fault to be noticed."""
_GROWTH = 0.05
"""Share by which memory may have grown after many faults."""
_MANY = 50
_DRAIN = 0.3
"""Seconds after a fault in which what was under way before may still be heard."""
_CALM = 0.5
"""Seconds between a recovery and the next fault."""


def recovered(show: Show, over: float, since: float) -> float | None:
    """Seconds from `over` until all were at work after `since`, monotonic times; None if never."""
    while time.monotonic() - over < _FOREVER and show.run.poll() is None:
        if tracked(show.judged(), since) and show.watch.works(since, CAMERAS):
            return time.monotonic() - over
        time.sleep(0.05)
    return None


def noticed(show: Show, begun: float) -> float | None:
    """Seconds until the run said that something was wrong, which tracking may not need; None if never."""
    while (seconds := show.watch.noticed(begun)) is None and time.monotonic() - begun < _UNNOTICED:
        time.sleep(0.05)
    return seconds


def tracked(judged: list[tuple[float, int, float]], since: float) -> bool:
    """True if the last frames were tracked after that time, correctly, and once: cameras agree on times."""
    last = judged[-_FRAMES:]
    frames = {frame for _, frame, _ in last}
    return len(frames) == _FRAMES and all(when > since and error < _RIGHT for when, _, error in last)


def pause(show: Show, begun: float, ended: float) -> float:
    """Longest time, s, between the fault and the recovery in which no frame was tracked right."""
    times = [begun, *(when for when, _, error in show.judged() if begun < when < ended and error < _RIGHT)]
    return max((b - a for a, b in pairwise(times)), default=ended - begun)


def memory(show: Show) -> int:
    """Bytes that all processes of the show take, shared ones counted once."""
    hosts = [show.run.pid, *(agent.process.pid for agent in show.agents.values())]
    total = 0
    for pid in [*hosts, *(pid for host in hosts for pid in descendants(host))]:
        try:
            text = Path(f"/proc/{pid}/smaps_rollup").read_text()
        except OSError:
            continue
        total += next(int(line.split()[1]) << 10 for line in text.splitlines() if line.startswith("Pss:"))
    return total


def soak(show: Show, faults: int, kinds: list[str], tell: Callable[[str], None]) -> list[dict[str, Any]]:
    """Inflict the faults one after the other; what became of each."""
    seen: list[dict[str, Any]] = []
    for number in range(faults):
        kind = kinds[number % len(kinds)] if number < len(kinds) else show.chance.choice(kinds)
        begun = time.monotonic()
        FAULTS[kind](show)
        over = time.monotonic()
        told = None if kind in UNSEEN else noticed(show, begun)
        back = recovered(show, over, over + _DRAIN)
        paused = pause(show, begun, time.monotonic())
        seen.append({"fault": kind, "back_s": back, "pause_s": paused, "noticed_s": told})
        heard = "" if kind in UNSEEN else f"noticed {_after(told)}, "
        tell(f"{number + 1}/{faults} {kind}: {heard}back {_after(back)}")
        if back is None:
            break
        time.sleep(_CALM)
        seen[-1]["memory"] = memory(show)
    return seen


def _after(seconds: float | None) -> str:
    return "never" if seconds is None else f"after {seconds:.1f} s"


def left_over(hosts: Hosts, before: set[str]) -> list[str]:
    """Processes in the namespaces of the hosts, and memory with a name that was not there before."""
    found = sorted(unused_memory() - before)
    for name in hosts.names:
        words = ["ip", "netns", "pids", hosts.space(name)]
        pids = subprocess.run(words, capture_output=True, text=True, check=False).stdout.split()
        found += [f"{name}: {Path(f'/proc/{pid}/cmdline').read_text()[:80]}" for pid in pids]
    return found


def summary_of(show: Show) -> dict[str, Any]:
    """End the run as Ctrl-C does; what it reports."""
    show.run.send_signal(signal.SIGINT)
    stdout, stderr = show.run.communicate(timeout=90)
    if not stdout.strip():
        return {"ok": False, "errors": [stderr[-2000:]], "edges": []}
    found: dict[str, Any] = json.loads(stdout.splitlines()[-1])
    return found


def compared(summary: dict[str, Any], journals: Journals) -> dict[str, Any]:
    """The number of lines of all journals, and their differences from the ledger."""
    return {"lines": journals.lines(), "differences": disagreements(summary["edges"], journals)}


def report(seen: list[dict[str, Any]], within: float, notice: float) -> dict[str, Any]:
    """Each kind of fault: how often, medians and the worst, s, and how often that was too long."""
    table = {}
    for kind in dict.fromkeys(entry["fault"] for entry in seen):
        of_kind = [entry for entry in seen if entry["fault"] == kind]
        backs = [_FOREVER if entry["back_s"] is None else entry["back_s"] for entry in of_kind]
        pauses = [entry["pause_s"] for entry in of_kind]
        told = [_FOREVER if entry["noticed_s"] is None else entry["noticed_s"] for entry in of_kind]
        table[kind] = {
            "count": len(backs),
            "pause_s": round(statistics.median(pauses), 2),
            "back_s": round(statistics.median(backs), 2),
            "worst_s": round(max(backs), 2),
            "late": sum(back > within for back in backs),
        }
        if kind not in UNSEEN:
            table[kind]["noticed_s"] = round(statistics.median(told), 2)
            table[kind]["noticed_worst_s"] = round(max(told), 2)
            table[kind]["noticed_late"] = sum(seconds > notice for seconds in told)
    return table


def growth(seen: list[dict[str, Any]]) -> float:
    """Memory in the last third of the time over that in the first, minus one: medians."""
    sizes = [entry["memory"] for entry in seen if "memory" in entry]
    third = max(1, len(sizes) // 3)
    return statistics.median(sizes[-third:]) / statistics.median(sizes[:third]) - 1 if sizes else 0.0


def played(args: argparse.Namespace) -> dict[str, Any]:
    """The whole show; what is to be printed."""
    started = time.monotonic()
    names = ["desk", *SIDES, "middle"]
    before = unused_memory()
    with tempfile.TemporaryDirectory() as folder, Hosts(Path(folder), names) as hosts:
        show = Show(hosts, random.Random(args.seed), args.projections)
        try:
            if recovered(show, time.monotonic(), 0.0) is None:
                raise SystemExit("the run did not begin")
            time.sleep(1.0)
            kinds = args.only or list(FAULTS)
            seen = soak(show, args.faults, kinds, lambda line: print(line, file=sys.stderr, flush=True))
            summary = summary_of(show)
            said = show.watch.news.union(summary.get("warnings", ()))
            journals = compared(summary, journals_of(show.journals, said, show.killed))
            show.end()
            left = left_over(hosts, before)
        finally:
            show.close()
    return {
        "faults": len(seen),
        "seconds": round(time.monotonic() - started, 1),
        "kinds": report(seen, args.within, args.notice),
        "ok": summary["ok"],
        "errors": summary.get("errors", []),
        "unaccounted": {e["from"]: e["in_flight"] for e in summary["edges"] if e["in_flight"]},
        "journals": journals,
        "statuses": {"seen": show.watch.seen, "impossible": sorted(show.watch.impossible)},
        "edges": summary["edges"],
        "memory_growth": round(growth(seen), 3),
        "left_over": left,
    }


def main() -> int:
    """Entry."""
    parser = options_of(__doc__)
    parser.add_argument("--faults", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--within", type=float, default=5.0, help="seconds that a recovery may take")
    parser.add_argument("--notice", type=float, default=2.0, help="seconds until a fault must be noticed")
    parser.add_argument(
        "--projections",
        type=int,
        default=0,
        help="projected spots for each ball: a ball that was missed for a while may be sought in one of them",
    )
    parser.add_argument("--only", nargs="+", action="extend", choices=list(FAULTS), metavar="FAULT")
    args = parser.parse_args()
    found = played(args)
    print(json.dumps(found) if args.json else json.dumps(found, indent=1))
    late = sum(kind["late"] + kind.get("noticed_late", 0) for kind in found["kinds"].values())
    grown = found["memory_growth"] > _GROWTH and found["faults"] >= _MANY
    untrue = found["journals"]["differences"] or found["statuses"]["impossible"]
    broken = late or grown or not found["ok"] or found["unaccounted"] or found["left_over"] or untrue
    return int(bool(broken))
