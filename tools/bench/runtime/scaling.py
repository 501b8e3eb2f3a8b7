"""Cost of a frame set over the number of cameras, targets and pixels, on simulated rooms.

    python tools/bench/runtime/scaling.py
    python tools/bench/runtime/scaling.py --cameras 2,6 --targets 3 --sizes 320x240 --json

Rooms are made from graphs/rooms/simulated6.yaml: more cameras are its cameras turned about the middle of
the room, more targets have hues of their own, larger pictures see the same with more pixels. One quantity
varies at a time; the others are as in that room. Frames are rendered into memory before the clock starts;
the cost is CPU time of one process, ms: the median of the rounds, tracked (once the first frames have found
the targets) and searching (no target is ever confirmed).
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import colorsys
import json
import statistics
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from benching.frames_in_memory import shots
from benching.stage_cost import measure
from followspot.graph.compile import compile_graph
from followspot.lens import IDENTITY
from followspot.room import Camera, Room, StageUse, Target
from followspot.room_file import load, save
from scripting import shown, table_options

ROOT = Path(__file__).parents[3]
CAMERAS, TARGETS = (2, 4, 6, 12, 24), (1, 3, 6, 12, 24)
SIZES = ((320, 240), (640, 480), (1280, 720), (1920, 1080))
USUAL = (6, 6, (320, 240))
"""Cameras, targets and image size while another quantity varies."""
BINS = 16


@dataclass(frozen=True)
class Case:
    """One room."""

    cameras: int
    targets: int
    size: tuple[int, int]


@dataclass(frozen=True)
class Row:
    """Cost of one room."""

    case: Case
    tracked_ms: float
    searching_ms: float
    targets_tracked: float
    stages_ms: dict[str, float]
    """CPU time of the tracked run, by stage."""


def main() -> None:
    """Measure and print the table."""
    args = parser().parse_args()
    cv2.setNumThreads(1)
    rows = []
    for case in cases(args):
        width, height = case.size
        print(f"{case.cameras} cameras, {case.targets} targets, {width}x{height}", file=sys.stderr)
        rows.append(cost(case, args))
    print(json.dumps([asdict(row) for row in rows]) if args.json else text(args, rows))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--cameras", help="numbers of cameras, default " + ",".join(map(str, CAMERAS)))
    options.add_argument("--targets", help="numbers of targets, default " + ",".join(map(str, TARGETS)))
    options.add_argument("--sizes", help="image sizes, default " + ",".join(f"{w}x{h}" for w, h in SIZES))
    options.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    options.add_argument("--frames", type=int, default=40, help="frame sets that are measured")
    options.add_argument("--warm-up", type=int, default=10, help="frame sets before them")
    options.add_argument("--rounds", type=int, default=3)
    return options


def cases(args: argparse.Namespace) -> list[Case]:
    """Each quantity varied alone; those named on the command line only, if one is named."""
    cameras = [int(n) for n in args.cameras.split(",")] if args.cameras else []
    targets = [int(n) for n in args.targets.split(",")] if args.targets else []
    sizes = [_size(text) for text in args.sizes.split(",")] if args.sizes else []
    if not (cameras or targets or sizes):
        cameras, targets, sizes = list(CAMERAS), list(TARGETS), list(SIZES)
    usual = Case(*USUAL)
    varied = [replace(usual, cameras=n) for n in cameras]
    varied += [replace(usual, targets=n) for n in targets]
    varied += [replace(usual, size=size) for size in sizes]
    return list(dict.fromkeys(varied))


def _size(text: str) -> tuple[int, int]:
    width, height = text.split("x")
    return int(width), int(height)


def cost(case: Case, args: argparse.Namespace) -> Row:
    """Render one room and run the graph over it."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "room.yaml"
        frames = args.warm_up + args.frames
        save(room_of(case, frames), file)
        plan = compile_graph(args.graph, room=file)
        played = shots(plan, frames)
        tracked, searching, stages, found = [], [], [], 0.0
        for _ in range(args.rounds):
            begin = measure(plan, played, Path(folder), frames=args.warm_up)
            whole = measure(plan, played, Path(folder))
            tracked.append((whole.total * frames - begin.total * args.warm_up) / args.frames)
            found = (whole.tracked * frames - begin.tracked * args.warm_up) / args.frames
            stages.append(whole.stages)
            searching.append(measure(plan, played, Path(folder), searching=True).total)
    by_stage = {name: statistics.median(s[name] for s in stages) for name in stages[0]}
    return Row(case, statistics.median(tracked), statistics.median(searching), found, by_stage)


def room_of(case: Case, frames: int) -> Room:
    """The room of a case, simulated for so many frames."""
    base = load(ROOT / "graphs/rooms/simulated6.yaml")
    models = list(base.cameras.values())
    colors = dict(hues(case.targets))
    use = StageUse("sim.camera", {**_performance(base), "frames": frames, "colors": colors})
    cameras = {}
    for number in range(case.cameras):
        camera = resized(turned(models[number % len(models)], number, case.cameras, len(models)), case.size)
        cameras[f"cam{number}"] = replace(camera, name=f"cam{number}", source=use)
    targets = {name: target(name, color, cameras, base) for name, color in colors.items()}
    return Room(f"{case.cameras} cameras", cameras, base.planes, targets)


def _performance(base: Room) -> dict[str, object]:
    source = next(iter(base.cameras.values())).source
    assert source is not None  # all cameras of that room are simulated
    return dict(source.params)


def turned(camera: Camera, number: int, count: int, models: int) -> Camera:
    """The camera rotated about the vertical through the middle of the room, so that views differ."""
    angle = 2 * np.pi * (number // models) / max(1, count)
    c, s = np.cos(angle), np.sin(angle)
    back = IDENTITY.copy()
    back[:2, :2] = [[c, s], [-s, c]]
    return replace(camera, rotation=camera.rotation @ back)


def resized(camera: Camera, size: tuple[int, int]) -> Camera:
    """The camera with another number of pixels and the same view across."""
    scale = size[0] / camera.size[0]
    matrix = camera.matrix * [[scale], [scale], [1.0]]
    matrix[1, 2] += (size[1] - scale * camera.size[1]) / 2
    return replace(camera, size=size, matrix=matrix)


def hues(count: int) -> Iterator[tuple[str, tuple[int, int, int]]]:
    """Names and RGB of targets: hues in the middle of the histogram's bins, farthest apart first."""
    order = np.argsort([int(f"{b:04b}"[::-1], 2) for b in range(BINS)])
    for number in range(count):
        red, green, blue = colorsys.hsv_to_rgb((order[number % BINS] + 0.5) / BINS, 0.85, 1.0)
        yield f"ball{number}", (round(255 * red), round(255 * green), round(255 * blue))


def target(name: str, color: Sequence[int], cameras: dict[str, Camera], base: Room) -> Target:
    """A ball of the base room in that colour, with templates for these cameras."""
    like = next(iter(base.targets.values()))
    histogram = np.zeros(BINS)
    histogram[int(colorsys.rgb_to_hsv(*color)[0] * BINS)] = 1.0
    low, high = next(iter(like.area.values()))
    gray = next(iter(like.gray.values()))
    areas = {c.name: (low * (c.size[0] / 320) ** 2, high * (c.size[0] / 320) ** 2) for c in cameras.values()}
    return Target(
        name,
        like.radius,
        {c.name: histogram for c in cameras.values() if c.kind == "color"},
        areas,
        {c.name: gray for c in cameras.values() if c.kind == "infrared"},
    )


def text(args: argparse.Namespace, rows: Sequence[Row]) -> str:
    """The table, and what the stages take of it."""
    names = list(rows[0].stages_ms) if rows else []
    cells = [
        (
            *(str(row.case.cameras), str(row.case.targets), "{}x{}".format(*row.case.size)),
            *(f"{row.tracked_ms:.2f}", f"{row.searching_ms:.2f}", f"{row.targets_tracked:.1f}"),
            *(f"{row.stages_ms[name]:.2f}" for name in names),
        )
        for row in rows
    ]
    return shown(args, ("cameras", "targets", "size", "tracked, ms", "searching, ms", "found", *names), cells)


if __name__ == "__main__":
    main()
