#!/usr/bin/env python3
"""CPU time and memory of a start: a run of one frame in one process, and in workers forked or spawned.

    python tools/bench_start.py [--rounds 5]

The sides take turns. The room is simulated: six cameras, and one worker for each beside the main one.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from unittest.mock import patch

import followspot as fs
from followspot.host.worker_starts import WorkerStarts

GRAPH = Path(__file__).parents[1] / "graphs" / "glowballs.yaml"
SIDES = ("one process", "forked", "spawned")


class _NoServer(WorkerStarts):
    """Starts each worker as a process that imports for itself."""

    def __init__(self, workers: Iterable[str], threads: Iterable[str], stages: Iterable[str]) -> None:
        super().__init__((), frozenset(threads), ())


def one_run(side: str) -> None:
    """The run itself, in a process of its own."""
    starts = _NoServer if side == "spawned" else WorkerStarts
    placement = None if side == "one process" else "camera"
    with (
        patch("followspot.host.worker_pool.WorkerStarts", starts),
        tempfile.TemporaryDirectory() as folder,
        fs.run(GRAPH, frames=1, placement=placement, out=Path(folder) / "out") as run,
    ):
        run.wait()


def cpu_seconds(side: str) -> float:
    """CPU time of a run with all its processes, s."""
    before = os.times()
    subprocess.run([sys.executable, __file__, "--side", side], check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main() -> None:
    """Print the medians and what the workers add, as a ratio."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="runs of each side (5)")
    parser.add_argument("--side", choices=SIDES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.side:
        one_run(options.side)
        return
    times: dict[str, list[float]] = {side: [] for side in SIDES}
    for _ in range(options.rounds):
        for side in SIDES:
            times[side].append(cpu_seconds(side))
    medians = {side: statistics.median(found) for side, found in times.items()}
    for side, seconds in medians.items():
        print(f"{side:12} {seconds:5.2f} s")
    one, forked, spawned = medians.values()
    print(f"seven workers, forked / spawned: {(forked - one) / (spawned - one):.2f}")


if __name__ == "__main__":
    main()
