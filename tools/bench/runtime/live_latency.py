"""Where each millisecond from capture to track goes in a live run, by placement and frame rate.

    python tools/bench/runtime/live_latency.py
    python tools/bench/runtime/live_latency.py --rates 30 --placements "one worker" camera --rounds 5 --json

Six simulated cameras are filmed into videos first; then these are decoded and tracked at the rate of the
cameras, in one worker, in two, in one for each camera, and in these over Zenoh. Rounds are interleaved. The
clock of a frame set starts when its frames are due. From the track back to the camera, along the inputs that
came last, every part of the time has one cause:

  stages        stages of that path work: what remains if nothing else costs anything
  other stages  the path waits while its worker runs stages that are not on it
  decoding      the path waits while its worker decodes pictures
  forecast      the path waits for the forecast of the frame set before
  hops          from the end of a stage until another worker has its message
  late frame    the frame enters the graph later than it is due, and its worker does nothing else
  runtime       all that is left: joins, scheduling, sending

`no core` is how much of all that a worker of the path was ready to run while others had the cores.

Parts are means over the frame sets of a round, for medians do not add up; all figures are medians of the
rounds. The aim is the stages, those that the path waits for too, and 0.5 ms a hop. The trace is in these runs
only (`tools/benching/live_trace.py`) and costs some microseconds a firing.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import fmean, median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benching import live_trace
from benching.frames_in_memory import shots
from benching.live_paths import OTHERS, PARTS, STAGES, Trace, Way
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.room import StageUse
from followspot.room_file import load, save
from followspot_sim.video import new_video
from scripting import followspot, shown, table_options

ROOT = Path(__file__).parents[3]
PLUGIN = ROOT / "tools/benching/live_trace.py"
PLACEMENTS: dict[str, tuple[str, ...]] = {
    "one worker": (),
    "two workers": ("--placement", str(ROOT / "graphs/placements/two.yaml")),
    "camera": ("--placement", "camera"),
    "camera, Zenoh": ("--placement", "camera", "--edges", "zenoh"),
}
LEAD = 10
"""Frame sets that are not measured: workers and caches are cold, and targets are sought."""
HOP_MS = 0.5
"""What the aim allows for a hop."""


@dataclass(frozen=True)
class Row:
    """One placement at one rate, ms. parts, no_core: means."""

    rate: float
    placement: str
    p50: float
    p95: float
    mean: float
    parts: dict[str, float]
    hops: float
    no_core: float
    aim: float


def main() -> None:
    """Film, run in turns, print."""
    args = parser().parse_args()
    if args.frames <= LEAD:
        raise SystemExit(f"--frames: the first {LEAD} are not measured, so there must be more")
    found: dict[tuple[float, str], list[Row]] = {}
    with TemporaryDirectory(prefix="followspot-live-") as name:
        folder = Path(name)
        rooms = {rate: filmed(args, rate, folder) for rate in args.rates}
        for number in range(args.rounds):
            for rate in args.rates:
                for placement in args.placements:
                    row = measured(args.graph, rooms[rate], rate, placement, folder)
                    found.setdefault((rate, placement), []).append(row)
                    print(f"round {number + 1}: {rate:g}/s, {placement}: {row.p50:.1f} ms", file=sys.stderr)
    rows = [middle(rounds) for rounds in found.values()]
    print(json.dumps([asdict(row) for row in rows]) if args.json else text(args, rows))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    options.add_argument("--room", default=str(ROOT / "graphs/rooms/simulated6.yaml"), help="a simulated one")
    options.add_argument("--rates", nargs="+", type=float, default=[30.0, 60.0], help="frames per second")
    options.add_argument("--placements", nargs="+", choices=PLACEMENTS, default=list(PLACEMENTS))
    options.add_argument("--frames", type=int, default=150, help="of each run (default %(default)s)")
    options.add_argument("--rounds", type=int, default=3, help="(default %(default)s)")
    return options


def filmed(args: argparse.Namespace, rate: float, folder: Path) -> Path:
    """The room whose cameras play videos of the simulated one at this rate."""
    plan = compile_graph(args.graph, room=args.room, overrides=[f"camera.fps={rate}"])
    room = load(Path(args.room))
    cameras = {}
    for name, frames in shots(plan, args.frames).items():
        file = folder / f"{name}-{rate:g}.mkv"
        with new_video(file, rate, room.cameras[name].size, len(frames)) as video:
            for frame in frames:
                video.write(np.broadcast_to(frame.pixels, (*frame.pixels.shape[:2], 3)))
        source = StageUse("live_trace.paced", {"path": str(file), "fps": rate})
        cameras[name] = replace(room.cameras[name], source=source)
    written = folder / f"room-{rate:g}.yaml"
    save(replace(room, cameras=cameras, truth=None), written)
    return written


def measured(graph: str, room: Path, rate: float, placement: str, folder: Path) -> Row:
    """One run."""
    words = [graph, "--room", str(room), "--plugin", str(PLUGIN), *PLACEMENTS[placement]]
    with TemporaryDirectory(dir=folder) as traces:
        os.environ[live_trace.FOLDER] = traces
        try:
            told = followspot("run", *words, "--out", str(folder / "out"))
        finally:
            del os.environ[live_trace.FOLDER]
        if not told["ok"]:
            raise SystemExit("\n".join(told["errors"]))
        ways = Trace(Path(traces), planned(graph, room, placement)).ways("track", LEAD)
    if not ways:
        raise SystemExit(f"{rate:g}/s: fewer than {LEAD + 1} frame sets came to the track")
    return figures(rate, placement, ways)


def planned(graph: str, room: Path, placement: str) -> Plan:
    """The plan of a run."""
    options: dict[str, Any] = dict(zip(PLACEMENTS[placement][::2], PLACEMENTS[placement][1::2], strict=True))
    return compile_graph(
        graph,
        room=room,
        placement=options.get("--placement"),
        edges=options.get("--edges", "auto"),
        plugin_files=[str(PLUGIN)],
    )


def figures(rate: float, placement: str, ways: Sequence[Way]) -> Row:
    """Of all frame sets of one run."""
    totals = [way.total / 1e6 for way in ways]
    parts = {part: fmean(way.parts[part] for way in ways) / 1e6 for part in PARTS}
    hops = fmean(way.hops for way in ways)
    p50, p95 = (float(found) for found in np.percentile(totals, (50, 95)))
    aim = parts[STAGES] + parts[OTHERS] + HOP_MS * hops
    no_core = fmean(way.waited for way in ways) / 1e6
    return Row(rate, placement, p50, p95, fmean(totals), parts, hops, no_core, aim)


def middle(rounds: Sequence[Row]) -> Row:
    """Medians over the rounds."""
    return replace(
        rounds[0],
        parts={part: median(row.parts[part] for row in rounds) for part in PARTS},
        **{
            name: median(getattr(row, name) for row in rounds)
            for name in ("p50", "p95", "mean", "hops", "no_core", "aim")
        },
    )


def text(args: argparse.Namespace, rows: Sequence[Row]) -> str:
    """The table."""
    cells = [
        (
            f"{row.placement}, {row.rate:g}/s",
            *(f"{value:.1f}" for value in (row.p50, row.p95, row.mean)),
            *(f"{row.parts[part]:.1f}" for part in PARTS),
            *(f"{value:.1f}" for value in (row.no_core, row.hops, row.aim)),
        )
        for row in rows
    ]
    heads = ("capture to track, ms", "p50", "p95", "mean", *PARTS, "no core", "number of hops", "aim")
    return shown(args, heads, cells)


if __name__ == "__main__":
    main()
