"""The six-camera tracker beside what else could join its stages: multiprocessing, ezmsg, dora.

    python tools/bench/runtime/peers.py --rounds 3    # pip install 'followspot[peers]' for ezmsg and dora

Every contender runs the same stages on the same pictures, a process for each camera and one for the
fusion (`tools/benching/peers/`). Each round runs all of them twice, one after the other: as fast as they can,
and paced. Time counts once all parts are ready; processor time and memory are those of all processes that a
contender has; `others` is the mean number of cores that other programs used meanwhile.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np

from benching.frames_in_memory import shots
from benching.peers.contender import Figures, Stalled, measured
from benching.peers.parts import LEAD, Order
from scripting import shown, table_options

ROOT = Path(__file__).parents[3]
PEERS = ROOT / "tools/benching/peers"
CONTENDERS = {
    "followspot, a process for each camera": ("followspot_graph", "camera"),
    "followspot, one process": ("followspot_graph",),
    "multiprocessing": ("pipeline",),
    "ezmsg": ("ezmsg_graph",),
    "dora": ("dora_graph",),
}
LINES = {"multiprocessing": ["pipeline"], "ezmsg": ["ezmsg_graph"], "dora": ["dora_graph", "dora_node"]}
"""Files that a user writes instead of a graph file, when the stages are there."""
NEEDS = {"ezmsg": "ezmsg", "dora": "dora"}


def main() -> None:
    """Measure in interleaved rounds; print medians and ratios to followspot in the same round."""
    options = parser().parse_args()
    if options.frames <= LEAD + 1:
        raise SystemExit(f"--frames: the first {LEAD} are not measured, so there must be more")
    if options.cores:
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: options.cores])
    contenders = [name for name in CONTENDERS if name in options.only and installed(name)]
    with TemporaryDirectory() as folder:
        order = Order(options.graph, options.room, folder, options.frames, options.rate)
        render(order)
        runs: dict[str, list[Figures]] = {name: [] for name in contenders}
        for name in contenders * options.rounds:
            runs[name] += one_round(order, name)
    results = {name: Figures(*map(median, zip(*found, strict=True))) for name, found in runs.items() if found}
    if options.json:
        print(json.dumps({name: found._asdict() for name, found in results.items()}, indent=2))
    else:
        print(text(options, results))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    options.add_argument("--room", default=str(ROOT / "graphs/rooms/simulated6.yaml"))
    options.add_argument("--frames", type=int, default=200)
    options.add_argument("--rate", type=float, default=30.0, help="frame sets per second when paced")
    options.add_argument("--rounds", type=int, default=3)
    options.add_argument("--cores", type=int, default=0, help="run on the first so many cores; 0: on all")
    options.add_argument("--only", nargs="+", choices=CONTENDERS, default=list(CONTENDERS))
    return options


def installed(name: str) -> bool:
    """Whether a contender is there; says so if not."""
    there = name not in NEEDS or importlib.util.find_spec(NEEDS[name]) is not None
    if not there:
        print(f"{name} is left out: pip install 'followspot[peers]'", file=sys.stderr)
    return there


def render(order: Order) -> None:
    """Write the pictures of all cameras, (frames, H, W, 3) or (frames, H, W, 1) uint8 each."""
    for camera, frames in shots(order.plan(), order.frames).items():
        np.save(order.path(f"{camera}.npy"), np.array([frame.pixels for frame in frames]))


def one_round(order: Order, name: str) -> list[Figures]:
    """The rate as fast as it goes, all else paced; nothing, with the reason printed, if a run stalls."""
    try:
        fast = measured(replace(order, rate=0.0), CONTENDERS[name])
        paced = measured(order, CONTENDERS[name])
    except Stalled as error:
        print(f"a round of {name} is left out: {error}", file=sys.stderr)
        return []
    others = (fast.others + paced.others) / 2
    return [paced._replace(per_second=fast.per_second, others=others)]


def lines(name: str) -> int:
    """Lines with code that a user writes to join the stages."""
    files = [PEERS / f"{file}.py" for file in LINES.get(name, ())] or [ROOT / "graphs/glowballs.yaml"]
    return sum(
        bool(line.strip()) and not line.strip().startswith(("#", '"""'))
        for file in files
        for line in file.read_text(encoding="utf-8").splitlines()
    )


def text(options: argparse.Namespace, results: dict[str, Figures]) -> str:
    """The results for people."""
    if not results:
        return "no contender came to its end"
    first = next(iter(results.values()))
    rows = [
        (
            name,
            f"{found.per_second:.0f}",
            *(f"{value:.1f}" for value in found[1:4]),
            f"{found.memory_mb:.0f}",
            str(lines(name)),
            f"{found.others:.1f}",
            *(f"{value / base:.2f}" for value, base in zip(found[:-1], first[:-1], strict=True)),
        )
        for name, found in results.items()
    ]
    heads = ("contender", "sets/s", "p50 ms", "p99 ms", "CPU ms", "MB", "lines", "others")
    return shown(options, (*heads, "x sets/s", "x p50", "x p99", "x CPU", "x MB"), rows)


if __name__ == "__main__":
    main()
