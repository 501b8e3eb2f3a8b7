"""What a longer delay of the forecast gives, over processes, and what it costs in accuracy.

    python tools/bench/runtime/forecast_delay.py --room dev1.yaml --room dev3.yaml
    python tools/bench/runtime/forecast_delay.py --room room.yaml --frames 150 --rounds 5 --size 640x480

With `delay: 2` the detectors of a frame work while the one before is fused, and a ball is sought where it was
forecast two frames ago. Accuracy is that of the default graph over all rooms given, which have ground truth.
Frame sets per second are those of the last room, whose cameras play videos from memory, tracked and searching
(no target is ever confirmed): in one process, and in as many as `auto` chose by a report of the first. Rounds
are interleaved, and ratios are those to one process with a delay of one in the same round. `others` is the
number of cores that other programs used meanwhile; what they took, a second process could not have. `set ms`
is the time of a frame set by the clock of the wall, `stages ms` how long stages and sources of all processes
work on it, and `busiest ms` how long those of the busiest process do.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import fmean, median
from tempfile import TemporaryDirectory
from typing import Any

import cv2

from bench.runtime.scaling import resized
from benching.processes import busy_time
from followspot.room_file import load, save
from scripting import followspot, shown, table_options

ROOT = Path(__file__).parents[3]
DELAYS = (1, 2, 3)
SIDES: dict[str, tuple[str, ...]] = {
    "tracked": (),
    "searching": ("track.minimum_support=1000000", "track.confirmation_frames=1000000"),
}
OVERLAY = """
graph: delayed
extends: {base}
stages:
  color:    {{in: {{forecast: {{from: track.forecast, delay: {delay}}}}}}}
  infrared: {{in: {{forecast: {{from: track.forecast, delay: {delay}}}}}}}
"""
PRELOADED = ROOT / "tools/benching/preloaded.py"
Cell = dict[str, Any]


def main() -> None:
    """Score all delays, then measure in turns."""
    args = parser().parse_args()
    cv2.setNumThreads(1)
    with TemporaryDirectory(prefix="followspot-delay-") as name:
        folder = Path(name)
        graphs = {delay: overlay(folder, delay) for delay in DELAYS}
        accuracy = [scored(graphs[delay], delay, args.room, folder) for delay in DELAYS]
        speed = [] if args.rounds < 1 else measured(graphs, args, folder)
    if args.json:
        print(json.dumps({"accuracy": accuracy, "speed": speed}))
        return
    print(text(args, accuracy))
    if speed:
        print("\n" + text(args, speed))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--room", action="append", required=True, help="with videos and truth; several")
    options.add_argument("--frames", type=int, default=150, help="of each measured run (default %(default)s)")
    options.add_argument("--rounds", type=int, default=3, help="0: accuracy only (default %(default)s)")
    options.add_argument("--size", default="640x480", help="of the pictures (default %(default)s)")
    return options


def overlay(folder: Path, delay: int) -> Path:
    """The default graph, whose detectors get the forecast of so many frames ago."""
    file = folder / f"delay{delay}.yaml"
    file.write_text(OVERLAY.format(base=ROOT / "graphs/glowballs.yaml", delay=delay), encoding="utf-8")
    return file


def scored(graph: Path, delay: int, rooms: Sequence[str], folder: Path) -> Cell:
    """Accuracy over all targets of all rooms."""
    told = [followspot("run", graph, "--room", room, "--out", folder / "scored") for room in rooms]
    targets = [target for run in told for target in run["targets"].values() if target["frames"] > 0]
    hidden = sum(target["hidden_frames"] for target in targets)
    recovered = [frames for target in targets for frames in target["recovery_frames"]]
    return {
        "delay": delay,
        "targets": len(targets),
        "coverage": fmean(target["coverage"] for target in targets),
        "RMSE mm": fmean(target["rmse_mm"] for target in targets),
        "p95 mm": fmean(target["p95_mm"] for target in targets),
        "false of hidden": sum(target["false_positions"] for target in targets) / max(hidden, 1),
        "switches": sum(target["identity_switches"] for target in targets),
        "recovery, frames": fmean(recovered) if recovered else 0.0,
    }


def measured(graphs: dict[int, Path], args: argparse.Namespace, folder: Path) -> list[Cell]:
    """Speed of each case, medians over the rounds."""
    room = preloaded(args, folder)
    length = ("--room", room, "--plugin", PRELOADED, "--out", folder / "run")
    rounds: list[dict[tuple[str, int, str], Cell]] = []
    for number in range(args.rounds):
        found = {}
        for case in cases():
            side, delay, placed = case
            words = [word for value in SIDES[side] for word in ("--set", value)]
            if placed == "auto":
                words += ["--placement", f"auto:{folder / f'{side}{delay}.json'}"]
            told, others = beside(partial(followspot, "run", graphs[delay], *length, *words))
            if placed == "one":
                (folder / f"{side}{delay}.json").write_text(json.dumps(told), encoding="utf-8")
            found[case] = figures(told, others)
            print(f"round {number + 1}: {case} {found[case]}", file=sys.stderr)
        rounds.append(found)
    return [
        row(case, [found[case] for found in rounds], [found[case[0], 1, "one"] for found in rounds])
        for case in cases()
    ]


def cases() -> Iterator[tuple[str, int, str]]:
    """Side, delay and placement."""
    for side in SIDES:
        for delay in DELAYS[:2]:
            for placed in ("one", "auto"):
                yield side, delay, placed


def preloaded(args: argparse.Namespace, folder: Path) -> Path:
    """The last room with larger pictures from memory."""
    width, height = map(int, args.size.split("x"))
    room = load(args.room[-1])
    cameras = {}
    for name, camera in room.cameras.items():
        if camera.source is None or "path" not in camera.source.params:
            raise SystemExit(f"{args.room[-1]}: camera {name} plays no video")
        path = (Path(args.room[-1]).parent / str(camera.source.params["path"])).resolve()
        use = replace(
            camera.source, uses="preloaded.preloaded", params={"path": str(path), "frames": args.frames}
        )
        cameras[name] = replace(resized(camera, (width, height)), source=use)
    save(replace(room, cameras=cameras), folder / "room.yaml")
    return folder / "room.yaml"


def figures(told: dict[str, Any], others: float) -> Cell:
    """Of one run."""
    if not told["ok"]:
        raise SystemExit("\n".join(told["errors"]))
    busy = [sum(stage["busy_ms"] for stage in worker["stages"]) for worker in told["workers"]]
    return {
        "workers": len(busy),
        "sets/s": told["frames"] / told["seconds"],
        "set ms": told["seconds"] * 1e3 / told["frames"],
        "stages ms": sum(busy) / told["frames"],
        "busiest ms": max(busy) / told["frames"],
        "others": others,
    }


def beside(run: Callable[[], dict[str, Any]]) -> tuple[dict[str, Any], float]:
    """The result of a run, and the mean number of cores that other programs used meanwhile."""
    busy, before = busy_time(), os.times()
    told = run()
    busy, after = busy_time() - busy, os.times()
    mine = sum(after[:4]) - sum(before[:4])  # with that of children that have ended
    return told, max(0.0, busy - mine) / max(after.elapsed - before.elapsed, 1e-9)


def row(case: tuple[str, int, str], runs: Sequence[Cell], one: Sequence[Cell]) -> Cell:
    """A case in the table, with ratios to one process with a delay of one in the same round."""
    side, delay, placed = case
    found: Cell = {"side": side, "delay": delay, "placement": placed}
    found |= {name: median(run[name] for run in runs) for name in runs[0]}
    found["x one"] = median(run["sets/s"] / base["sets/s"] for run, base in zip(runs, one, strict=True))
    return found


def text(args: argparse.Namespace, rows: Sequence[Cell]) -> str:
    """A table for people."""
    cells = [[cell(value) for value in found.values()] for found in rows]
    return shown(args, tuple(rows[0]), cells)


def cell(value: Any) -> str:
    """Three digits of a number, and no more than the thousandths."""
    return f"{round(value, 3):.3g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main()
