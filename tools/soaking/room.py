"""The graph and room of tools/soak.py: the tracker of glowing balls with live simulated cameras."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

GRAPHS = Path(__file__).parents[2] / "graphs"
CAMERAS = 6
"""Cameras that run to the end."""
SHORT = "cam6"
"""The camera that ends early."""
SHORT_S = 15
"""Seconds until then."""
FPS = 10
"""Rate of the cameras, 1/s."""
_MISSING = 4
"""Frames after which a target that is not seen is sought everywhere: as long as at 60 frames a second."""
PERFORMANCE = {"fps": FPS, "seed": 7, "people": 2}
JOURNALED = {
    "room.source": "room.source",  # which the room names
    "balls.color_blobs": "journaled.color_blobs",
    "balls.ir_blobs": "journaled.ir_blobs",
    "balls.verify_pairs": "journaled.verify_pairs",
    "balls.triangulate": "journaled.triangulate",
    "balls.associate_tracked": "journaled.associate_tracked",
    "balls.mean_shift": "journaled.mean_shift",
    "balls.bridge": "journaled.bridge",
    "balls.kalman": "journaled.kalman",
    "sinks.csv": "journaled.csv_file",
}
PLACEMENT = f"""
placement: soak
workers:
  left:  {{host: pc-left, cameras: [cam0, cam1]}}
  right: {{host: pc-right, cameras: [cam2, cam3], stages: [infrared/{SHORT}]}}
  short: {{host: pc-right, stages: [camera/{SHORT}]}}
  desk:  {{cameras: [cam4, cam5]}}
"""


def write_files(folder: Path, opened: float, projections: int) -> None:
    """Graph, room and placement.

    opened: since when time goes on in the room, s of the monotonic clock; projections: spots for each ball.
    """
    graph = yaml.safe_load((GRAPHS / "glowballs.yaml").read_text())
    graph["room"] = "room.yaml"
    for stage in graph["stages"].values():  # stages with journals
        stage["uses"] = JOURNALED[stage["uses"]]
    graph["stages"]["save"] |= {"in": {"messages": "track.tracks"}, "on_error": "skip"}  # as journals name it
    graph["stages"]["track"]["with"] = {"maximum_missed_frames": _MISSING}
    judge = {"uses": "journaled.judge", "in": {"tracks": "track"}, "with": PERFORMANCE, "on_error": "skip"}
    graph["stages"]["judge"] = judge
    (folder / "soak.yaml").write_text(yaml.safe_dump(graph))
    (folder / "room.yaml").write_text(yaml.safe_dump(_room(opened, projections)))
    (folder / "placement.yaml").write_text(PLACEMENT)


def _room(opened: float, projections: int) -> dict[str, Any]:
    """The simulated room with live cameras, and one more with the same view as another."""
    room: dict[str, Any] = yaml.safe_load((GRAPHS / "rooms" / "simulated.yaml").read_text())
    del room["truth"]
    room["cameras"][SHORT] = dict(room["cameras"]["cam1"])
    for target in room["targets"].values():
        for learnt in (target["area"], target["gray"]):
            learnt[SHORT] = learnt["cam1"]
    for name, camera in room["cameras"].items():
        frames = SHORT_S * FPS if name == SHORT else 0
        shown = {**PERFORMANCE, "projections": projections, "frames": frames, "opened": opened}
        camera["source"] = {"uses": "journaled.live_camera", "with": shown}
    return room
