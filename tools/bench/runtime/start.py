"""CPU time of a start, and memory of each process: of a run in one process, and in workers forked or spawned.

    python tools/bench/runtime/start.py
    python tools/bench/runtime/start.py --rounds 5 --frames 300

The room is simulated: six cameras, and one worker for each beside the main one. The sides take turns: CPU
time is that of a run of one frame, the command with it. Memory is that of the moment with the largest sum, in
a run at 30 frames per second: resident, the share of it if what several processes have in common is shared
out, and what a process has for itself.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, median
from typing import Any
from unittest.mock import patch

import followspot as fs
from benching.processes import Memory, family, memory
from followspot.host.worker_starts import WorkerStarts
from scripting import shown, table_options

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
SIDES = ("one process", "forked", "spawned")
WORKERS = 7
PACED = {"camera.realtime": True, "camera.fps": 30.0}


class _NoServer(WorkerStarts):
    """Starts each worker as a process that imports for itself."""

    def __init__(self, workers: Iterable[str], threads: Iterable[str], stages: Iterable[str]) -> None:
        super().__init__((), frozenset(threads), ())


@dataclass(frozen=True)
class Row:
    """Processes of one kind. count: how many; memory: mean of them."""

    side: str
    process: str
    count: int
    memory: Memory


def main() -> None:
    """Measure in turns, print medians and what the workers add."""
    args = parser().parse_args()
    if args.side:
        one_run(args.side, args.frames)
        return
    times: dict[str, list[float]] = {side: [] for side in SIDES}
    for _ in range(args.rounds):
        for side in SIDES:
            times[side].append(cpu_seconds(side))
    seconds = {side: median(found) for side, found in times.items()}
    rows = [row for side in SIDES for row in by_process(side, args.frames)]
    if args.json:
        print(json.dumps({"cpu_s": seconds, "memory": [vars(row) | row.memory._asdict() for row in rows]}))
        return
    print(text(args, seconds, rows))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--rounds", type=int, default=5, metavar="N", help="runs of each side (5)")
    options.add_argument("--frames", type=int, default=90, help="of the runs whose memory is measured (90)")
    options.add_argument("--side", choices=SIDES, help=argparse.SUPPRESS)
    return options


def one_run(side: str, frames: int) -> None:
    """The run itself, in a process of its own."""
    starts = _NoServer if side == "spawned" else WorkerStarts
    placement = None if side == "one process" else "camera"
    settings: Mapping[str, Any] = PACED if frames > 1 else {}
    with (
        patch("followspot.host.worker_pool.WorkerStarts", starts),
        tempfile.TemporaryDirectory() as folder,
        fs.run(GRAPH, frames=frames, placement=placement, set=settings, out=Path(folder) / "out") as run,
    ):
        run.wait()


def command(side: str, frames: int) -> list[str]:
    """The command that starts one run."""
    return [sys.executable, __file__, "--side", side, "--frames", str(frames)]


def cpu_seconds(side: str) -> float:
    """CPU time of a run with all its processes, s."""
    before = os.times()
    subprocess.run(command(side, 1), check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def by_process(side: str, frames: int) -> list[Row]:
    """Memory by kind of process, when all together had most."""
    most: dict[int, Memory] = {}
    parents: dict[int, int] = {}
    with subprocess.Popen(command(side, frames), start_new_session=True) as process:
        while process.poll() is None:
            found = memory(process.pid)
            if total(found.values()) > total(most.values()):
                most, parents = found, family(process.pid)
            time.sleep(0.05)
    if process.returncode:
        raise SystemExit(f"the run of {side} failed")
    kinds: dict[str, list[Memory]] = {}
    for pid, one in most.items():
        kinds.setdefault(kind(pid, process.pid, parents, forked=side == "forked"), []).append(one)
    return [
        Row(side, name, len(found), Memory(*map(fmean, zip(*found, strict=True))))
        for name, found in sorted(kinds.items())
    ]


def kind(pid: int, command: int, parents: Mapping[int, int], *, forked: bool) -> str:
    """The role of a process of a run."""
    if pid == command:
        return "command"
    return "fork server" if forked and parents.get(pid) == command else "worker"


def total(found: Iterable[Memory]) -> float:
    """Memory of several processes, MB."""
    return sum(one.shared_out for one in found)


def text(args: argparse.Namespace, seconds: Mapping[str, float], rows: Iterable[Row]) -> str:
    """Both tables."""
    one, forked, spawned = seconds.values()
    added = {
        "one process": "",
        "forked": f"{(forked - one) / WORKERS:.2f}",
        "spawned": f"{(spawned - one) / WORKERS:.2f}",
    }
    starts = [(side, f"{found:.2f}", added[side]) for side, found in seconds.items()]
    cells = [
        (f"{row.side}: {row.process}", str(row.count), *(f"{value:.0f}" for value in row.memory))
        for row in rows
    ]
    heads = ("memory of each process, MB", "processes", "resident", "shared out", "its own")
    by_start = shown(args, ("CPU time of a start, s", "all", "a worker more"), starts)
    return f"{by_start}\n\n{shown(args, heads, cells)}"


if __name__ == "__main__":
    main()
