"""Frames per second of the six-camera tracker against a plain single-file OpenCV script doing the same work.

    python tools/bench_tracker.py --room room.yaml

The room's cameras play videos. Frames are decoded into memory before the clock starts, on every side: the
plain script (tools/plain_tracker.py), the graph in one process, and the graph in two. Rounds are
interleaved; the ratio of each pair of one round is what counts on a noisy machine.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2

import plain_tracker
from followspot.deploy.launch import run_plan
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.messages import Array
from followspot.plugins.registry import load_stage, use_plugin_files
from followspot.runtime.wiring import RunOptions
from followspot.stage import Context

ROOT = Path(__file__).parent.parent
PRELOADED = '''
"""Plays a video from memory."""

from pathlib import Path

from followspot import Field, Source, Stage, StageParams, at
from followspot.plugins.registry import load_stage
from followspot.tracking import Frame


class Preloaded(Stage):
    """Decodes in `setup`, before the clock starts."""

    class Params(StageParams):
        path: Path = Field(description="the video file")
        count: int = Field(description="most frames to play", unit="1")

    per_camera = True

    def setup(self) -> None:
        source = load_stage("cameras.video")(self.context, path=self.params.path, frames=self.params.count)
        source.setup()
        self.frames = [(frame.header.time, frame.pixels.copy()) for frame in source.process()]
        source.close()

    def process(self) -> Source[Frame]:
        for time, pixels in self.frames:
            yield at(time, Frame(self.camera.name, pixels))
'''


def preloaded(plan: Plan, frames: int) -> Plan:
    """The plan with every video played from memory."""
    stages = tuple(
        replace(s, uses="preloaded.preloaded", params={"path": s.params["path"], "count": frames})
        if s.uses == "cameras.video"
        else s
        for s in plan.stages
    )
    return replace(plan, stages=stages)


def decoded(plan: Plan, frames: int) -> dict[str, list[Array]]:
    """All pictures of all cameras."""
    pictures = {}
    for stage in plan.stages:
        if stage.uses == "cameras.video" and stage.camera is not None:
            camera = plan.room.cameras[stage.camera]
            source = load_stage(stage.uses)(Context(room=plan.room, camera=camera), **stage.params)
            source.setup()
            played = [frame.pixels.copy() for frame, _ in zip(source.process(), range(frames), strict=False)]
            pictures[stage.camera] = played
            source.close()
    return pictures


def main() -> None:
    """Measure in interleaved rounds and print medians and ratios."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--room", required=True, help="room file whose cameras play videos")
    parser.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    parser.add_argument("--placement", default=str(ROOT / "graphs/placements/two.yaml"))
    parser.add_argument("--targets", help="track only these, for example red,green; default: all")
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    cv2.setNumThreads(1)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "preloaded.py"
        file.write_text(PRELOADED, encoding="utf-8")
        use_plugin_files([str(file)])
        sides = _sides(args, Path(folder), str(file))
        rates: dict[str, list[float]] = {name: [] for name in sides}
        for number in range(args.rounds):
            for name, side in sides.items():
                rates[name].append(side())
                print(f"round {number + 1}: {name} {rates[name][-1]:.1f} frames/s", file=sys.stderr)
    _print(rates, as_json=args.json)


def _sides(args: argparse.Namespace, out: Path, plugin: str) -> dict[str, Callable[[], float]]:
    wanted = args.targets.split(",") if args.targets else None

    def compiled(placement: str | None) -> Plan:
        plan = compile_graph(args.graph, room=args.room, placement=placement, plugin_files=[plugin])
        targets = {n: t for n, t in plan.room.targets.items() if wanted is None or n in wanted}
        return replace(plan, room=replace(plan.room, targets=targets))

    one, two = compiled(None), compiled(args.placement)
    pictures = decoded(one, args.frames)
    count = min(map(len, pictures.values()))

    def plain() -> float:
        started = time.perf_counter()
        plain_tracker.run(one.room, pictures)
        return count / (time.perf_counter() - started)

    def graph(plan: Plan) -> Callable[[], float]:
        def run() -> float:
            report = run_plan(preloaded(plan, args.frames), RunOptions(out))
            if not report.ok:
                raise SystemExit("\n".join(report.errors))
            return report.frames / report.seconds

        return run

    return {"plain script": plain, "one process": graph(one), "two processes": graph(two)}


def _print(rates: dict[str, list[float]], *, as_json: bool) -> None:
    plain = rates["plain script"]
    result = {
        name: {
            "frames_per_second": statistics.median(values),
            "ratio": statistics.median(v / p for v, p in zip(values, plain, strict=True)),
        }
        for name, values in rates.items()
    }
    if as_json:
        print(json.dumps(result))
        return
    for name, row in result.items():
        print(f"{name:<14} {row['frames_per_second']:7.1f} frames/s   {row['ratio']:.2f} x the plain script")


if __name__ == "__main__":
    main()
