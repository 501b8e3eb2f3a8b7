"""Recording of live cameras: messages sent, delivered, dropped and lost, by the ledger.

    python tools/bench/recording/live_cameras.py
    python tools/bench/recording/live_cameras.py --cameras 6 --fps 60 --seconds 20 --pictures none --json

Live cameras of 320x240 in one worker, each with a thread of its own, and the recording worker beside it, as
`followspot run --record` makes it. The pictures are noisy, so that they compress like those of a sensor.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, ClassVar

import numpy as np

from followspot import Field, Source, Stage, StageParams, at
from followspot.tracking import Frame
from followspot.worker.ledger import COUNTS
from scripting import followspot, options_of

_WIDTH, _HEIGHT = 320, 240


class PacedCamera(Stage):
    """A live camera with noisy pictures at a fixed rate."""

    live: ClassVar[bool] = True
    per_camera: ClassVar[bool] = True

    class Params(StageParams):
        fps: float = Field(60.0, gt=0, description="frames per second", unit="Hz")
        seconds: float = Field(10.0, gt=0, description="how long it films", unit="s")

    params: Params

    def process(self) -> Source[Frame]:
        """A frame each 1 / fps; a few pictures take turns."""
        scene = np.linspace(20, 120, _WIDTH)[None, :, None] + np.zeros((_HEIGHT, _WIDTH, 3))
        noisy = [np.clip(self.rng.normal(scene, 3.0), 0, 255).astype("u1") for _ in range(8)]
        began = time.monotonic()
        for number in range(round(self.params.fps * self.params.seconds)):
            due = number / self.params.fps
            time.sleep(max(0.0, began + due - time.monotonic()))
            yield at(round(due * 1e9), Frame(self.camera.name, noisy[number % len(noisy)].copy()))


def measure(cameras: int, fps: float, seconds: float, pictures: str) -> dict[str, Any]:
    """Run and record; counts of all edges, and what the recording cost."""
    with TemporaryDirectory() as folder:
        room, graph, file = (Path(folder) / name for name in ("room.yaml", "graph.yaml", "show.mcap"))
        lens = f"matrix: [[300, 0, {_WIDTH / 2}], [0, 300, {_HEIGHT / 2}], [0, 0, 1]]"
        pose = "rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], translation: [0, 0, 3]"
        words = f"{{kind: color, size: [{_WIDTH}, {_HEIGHT}], model: pinhole, {lens}, {pose}}}"
        lines = "\n".join(f"  cam{number}: {words}" for number in range(cameras))
        room.write_text(f"room: bench\ncameras:\n{lines}\n")
        uses = f"uses: {Path(__file__).stem}.paced_camera, each: cameras"
        given = f"with: {{fps: {fps}, seconds: {seconds}}}"
        graph.write_text(f"graph: bench\nroom: room.yaml\nstages:\n  camera: {{{uses}, {given}}}\n")
        record = ["--record", str(file), "--record-pictures", pictures, "--out", folder]
        report = followspot("run", str(graph), "--plugin", __file__, *record)
        size = file.stat().st_size
    stages = [stage for worker in report["workers"] for stage in worker["stages"]]
    busy = sum(stage["busy_ms"] for stage in stages if stage["stage"].startswith("record"))
    totals = {name: sum(edge[name] for edge in report["edges"]) for name in COUNTS}
    costs = {"MB_per_s": size / seconds / 1e6, "busy": busy / 1e3 / seconds, "ok": report["ok"]}
    return {"cameras": cameras, "fps": fps, "seconds": seconds, "pictures": pictures, **totals, **costs}


def main() -> int:
    """Measure, print; 1 if messages were lost."""
    parser = options_of(__doc__)
    parser.add_argument("--cameras", type=int, default=6, help="how many (default 6)")
    parser.add_argument("--fps", type=float, default=60.0, help="frames per second of each (default 60)")
    parser.add_argument("--seconds", type=float, default=10.0, help="how long they film (default 10)")
    parser.add_argument("--pictures", choices=("jpeg", "png", "raw", "none"), default="jpeg")
    args = parser.parse_args()
    found = measure(args.cameras, args.fps, args.seconds, args.pictures)
    if args.json:
        print(json.dumps(found))
    else:
        print(f"{args.cameras} cameras of {_WIDTH}x{_HEIGHT} at {args.fps:g} per second, {args.seconds:g} s")
        print("  " + ", ".join(f"{found[name]} {name.replace('_', ' ')}" for name in COUNTS))
        print(
            f"  {found['MB_per_s']:.0f} MB/s into the file; the recording worker was busy {found['busy']:.0%}"
        )
    return 0 if found["ok"] and found["sent"] == found["delivered"] else 1


if __name__ == "__main__":
    sys.exit(main())
