"""The tracker on recordings, and the room and the frames that they have."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
from tests.datasets import dataset
from tests.plugins.balls.scene import learn_color

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, stamped
from followspot.room import Camera, Room, Target
from followspot.stage import Stage
from followspot.tracking import Forecast, Frame
from followspot_balls.bridge import Bridge
from followspot_balls.color_blobs import ColorBlobs
from followspot_balls.ir_blobs import IrBlobs
from followspot_balls.kalman import Kalman
from followspot_balls.mean_shift import MeanShift
from followspot_balls.templates.from_clip import learn_infrared
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs
from followspot_target_filter.stage import Outputs

RECORDINGS = dataset("glowballs-dev")
FRAME_NS = 33_333_333


def ready(kind: type[Stage], room: Room, camera: Camera | None = None) -> Stage:
    stage = kind(Context(room=room) if camera is None else Context.serving(camera, room))
    stage.setup()
    return stage


def track(
    room: Room, frames: Sequence[dict[str, Frame]], fusion: type[Stage] = MeanShift
) -> Iterator[Outputs]:
    """Run the stages as the graph would, with sealed messages and the forecast of the frame before."""
    detectors = {
        n: ready(ColorBlobs if c.kind == "color" else IrBlobs, room, c) for n, c in room.cameras.items()
    }
    verify, triangulate = ready(VerifyPairs, room), ready(Triangulate, room)
    fuse, bridge, kalman = ready(fusion, room), ready(Bridge, room), ready(Kalman, room)
    forecast = Forecast.empty()
    for number, pictures in enumerate(frames):
        blobs = tuple(seal(detectors[n].process(pictures[n], forecast)) for n in pictures)
        candidates = seal(triangulate.process(seal(verify.process(blobs)), forecast))
        fused = seal(fuse.process(candidates, forecast))
        positions = stamped(bridge.process(fused, blobs, forecast), Header("", number, number * FRAME_NS))
        outputs = kalman.process(seal(positions))
        forecast = seal(outputs.forecast)
        seal(outputs.tracks)
        yield outputs


def read_video(path: Path) -> list[Array]:
    video, frames = cv2.VideoCapture(str(path)), []
    while True:
        good, frame = video.read()
        if not good:
            return frames
        frames.append(frame)


def recorded_room(names: Sequence[str]) -> Room:
    """Calibration and learnt templates of the recordings."""
    data = json.loads((RECORDINGS / "calibration.json").read_text())
    cameras, targets = {}, {}
    for c in data["cameras"]:
        kind = "color" if c["kind"] == "color" else "infrared"
        parts = (np.array(c[k], float) for k in ("K", "dist", "R", "t"))
        cameras[c["name"]] = Camera(c["name"], kind, (c["width"], c["height"]), *parts)  # type: ignore[arg-type]
    for name in names:
        clips = {c: read_video(RECORDINGS / "templates" / name / f"{c}.mkv") for c in cameras}
        color = {c: learn_color(f) for c, f in clips.items() if cameras[c].kind == "color"}
        infrared = {c: learn_infrared(f) for c, f in clips.items() if cameras[c].kind == "infrared"}
        targets[name] = Target(
            name,
            data["ball_radius_m"],
            {c: histogram for c, (histogram, _) in color.items()},
            {c: area for c, (_, area) in (color | infrared).items()},
            {c: gray for c, (gray, _) in infrared.items()},
        )
    planes = {k: np.array(v["metres"]) for k, v in data["planes"].items()}
    return Room("recorded", cameras, planes, targets)


def recorded_frames(room: Room, sequence: str) -> list[dict[str, Frame]]:
    videos = {n: read_video(RECORDINGS / sequence / f"{n}.mkv") for n in room.cameras}
    frames = []
    for i in range(len(videos["cam0"])):
        pictures = {}
        for n, c in room.cameras.items():
            pixels = videos[n][i] if c.kind == "color" else videos[n][i][..., :1]
            pictures[n] = seal(Frame(camera=n, pixels=np.ascontiguousarray(pixels)))
        frames.append(pictures)
    return frames
