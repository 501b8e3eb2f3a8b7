"""Latency from capture to track beside programs that use all cores, by what a placement asks of its host.

    python tools/bench/runtime/busy_machine.py
    python tools/bench/runtime/busy_machine.py --rounds 5 --frames 300 --json

The simulated cameras film at 30 per second; two other processes count without end. Rounds are interleaved: a
round has the run alone, beside them, and beside them with `nice` and with `realtime`. What this host refuses
is said, and that run is one without it.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from scripting import followspot, shown, table_options

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
PACED = ("--set", "camera.realtime=true", "--set", "camera.fps=30")
ASKED = {
    "alone": "",
    "beside two others": "",
    "beside two others, nice: -10": "nice: -10",
    "beside two others, realtime: 10": "realtime: 10",
}
_STAGES = "camera, color, infrared, verify, triangulate, associate, fuse, bridge, track, save"
FIGURES = ("p50_ms", "p95_ms", "p99_ms", "worst_ms")
_BURN = "while True: pass"


@contextmanager
def burners(count: int) -> Iterator[None]:
    """So many processes that use a core each, until the end of the block."""
    found = [subprocess.Popen([sys.executable, "-c", _BURN]) for _ in range(count)]
    try:
        yield
    finally:
        for process in found:
            process.kill()
            process.wait()


def measure(asked: str, others: int, frames: int, folder: Path) -> dict[str, Any]:
    """Latency of the path from the cameras to the tracks, ms, and what the host refused."""
    placement = folder / "placement.yaml"
    worker = ", ".join(filter(None, (f"stages: [{_STAGES}]", asked)))
    placement.write_text(f"workers: {{main: {{{worker}}}}}\nbudget: {{camera -> track: 1 s}}\n")
    with burners(others):
        length = ("--frames", str(frames), "--out", str(folder))
        told = followspot("run", str(GRAPH), *PACED, "--placement", str(placement), *length)
    (path,) = (path for path in told["paths"] if path["to"] == "track")
    figures = {name: path[name] for name in FIGURES}
    return {**figures, "refused": [text for text in told["warnings"] if "not allowed" in text]}


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--frames", type=int, default=150, help="of each run (default 150)")
    options.add_argument("--rounds", type=int, default=3, help="how often, in turns (default 3)")
    return options


def main() -> int:
    """Measure in turns, print medians."""
    args = parser().parse_args()
    found: dict[str, list[dict[str, Any]]] = {name: [] for name in ASKED}
    with TemporaryDirectory(prefix="followspot-beside-") as folder:
        for _ in range(args.rounds):
            for name, asked in ASKED.items():
                found[name].append(measure(asked, 0 if name == "alone" else 2, args.frames, Path(folder)))
    rows = {
        name: {
            **{key: median(run[key] for run in runs) for key in FIGURES},
            "refused": runs[0]["refused"],
        }
        for name, runs in found.items()
    }
    if args.json:
        print(json.dumps(rows))
        return 0
    cells = [(name, *(f"{row[key]:.1f}" for key in FIGURES)) for name, row in rows.items()]
    heads = ("camera to track, ms", *(key.removesuffix("_ms") for key in FIGURES))
    print(shown(args, heads, cells))
    for name, row in rows.items():
        for refused in row["refused"]:
            print(f"{name}: {refused.splitlines()[0]}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
