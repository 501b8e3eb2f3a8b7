"""Byte-for-byte replay of a long recording, and its cost in time, memory and disk.

    python tools/bench/recording/replay.py
    python tools/bench/recording/replay.py --minutes 0.1 --json

Three cameras of the simulated room, with half as many pixels each way, at 25 per second: the run is recorded
with all ports as fast as it goes, then `followspot verify` computes all that can be computed again.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import resource
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from scripting import followspot, options_of

GRAPHS = Path(__file__).parents[3] / "graphs"
CAMERAS = ("cam0", "cam1", "cam2")
FPS = 25


def small_room(frames: int) -> dict[str, Any]:
    """The simulated room with three cameras of 160x120."""
    room: dict[str, Any] = yaml.safe_load((GRAPHS / "rooms" / "simulated.yaml").read_text())
    room["cameras"] = {name: _halved(room["cameras"][name]) for name in CAMERAS}
    for target in room["targets"].values():
        target["hue_histogram"] = _kept(target["hue_histogram"])
        target["gray"] = _kept(target["gray"])
        target["area"] = {name: [size / 4 for size in area] for name, area in _kept(target["area"]).items()}
    for source in (room["truth"], *(camera["source"] for camera in room["cameras"].values())):
        source["with"] = {**source["with"], "frames": frames, "fps": FPS}
    return room


def _halved(camera: Mapping[str, Any]) -> dict[str, Any]:
    (fx, _, cx), (_, fy, cy), last = camera["matrix"]
    matrix = [[fx / 2, 0, cx / 2], [0, fy / 2, cy / 2], last]
    return {**camera, "size": [side // 2 for side in camera["size"]], "matrix": matrix}


def _kept(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name in CAMERAS}


def measure(minutes: float) -> dict[str, Any]:
    """Record and verify; what was compared, and what it cost."""
    frames = round(minutes * 60 * FPS)
    with TemporaryDirectory(prefix="followspot-replay-") as folder:
        room, file = Path(folder) / "room.yaml", Path(folder) / "show.mcap"
        room.write_text(yaml.safe_dump(small_room(frames)))
        graph = str(GRAPHS / "glowballs.yaml")
        began = time.monotonic()
        record = ["run", graph, "--room", str(room), "--record", str(file), "--record-pictures", "none"]
        followspot(*record, "--out", folder)
        recorded, cpu = time.monotonic(), _cpu()
        told = followspot("verify", str(file))
        verified = time.monotonic()
        return {
            "minutes": minutes,
            "frames": frames,
            "same": told["same"],
            "ports": len(told["ports"]),
            "messages": sum(port["messages"] for port in told["ports"]),
            "file_MB": file.stat().st_size / 1e6,
            "record_s": recorded - began,
            "verify_s": verified - recorded,
            "verify_cpu_s": _cpu() - cpu,
            "largest_process_MiB": resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024,
        }


def _cpu() -> float:
    """CPU time of all processes started so far, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> int:
    """Measure, print; 1 if something differs."""
    parser = options_of(__doc__)
    parser.add_argument("--minutes", type=float, default=10.0, help="length of the recording (default 10)")
    args = parser.parse_args()
    found = measure(args.minutes)
    if args.json:
        print(json.dumps(found))
    else:
        for name, value in found.items():
            print(f"{name:20} {value:.1f}" if isinstance(value, float) else f"{name:20} {value}")
    return 0 if found["same"] else 1


if __name__ == "__main__":
    sys.exit(main())
