"""Frames per second of the fast part of pose tracking on one core, over its number of particles.

    python tools/bench/persons/speed.py --room room.yaml --particles 300

The room's first camera plays a video. The slow instance (hog, appearance) works on it first, at leisure; its
messages and the frames stay in memory. Then gradients and pose_tracker take every frame, with CPU time of one
thread as the clock. What they need depends on how many people are there, which is told, too.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import time
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from followspot import Room, Stage
from followspot.context import Context
from followspot.graph.parameters import path_parameters
from followspot.messages import Message, stamped
from followspot.people import Appearances, Boxes
from followspot.plugins.registry import load_stage
from followspot.room import StageUse
from followspot.room_file import load
from followspot.stage_params import PathIn
from followspot.tracking import Frame
from scripting import options_of


@dataclass(frozen=True)
class Shot:
    """A frame and the newest messages of the slow instance that are known by then."""

    frame: Frame
    people: Appearances | None
    boxes: Boxes | None


def main() -> None:
    """Measure; print one line, or JSON."""
    parser = options_of(__doc__)
    parser.add_argument("--room", required=True, help="room file whose first camera plays a video")
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--particles", type=int, default=300, help="for each person")
    parser.add_argument("--every", type=int, default=4, help="frames between two of the slow instance")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    room = load(given.room)
    figures = measure(room, shots(room, given.frames, given.every), given.particles)
    if given.json:
        print(json.dumps(figures))
        return
    print(
        f"{figures['frames_per_s']:.1f} frames/s of {figures['size'][0]} x {figures['size'][1]} on one core, "
        f"{figures['particles']} particles a person, {figures['persons']:.1f} persons a frame: "
        f"gradients {figures['gradients_ms']:.1f} ms, pose_tracker {figures['pose_tracker_ms']:.1f} ms"
    )


def shots(room: Room, frames: int, every: int) -> list[Shot]:
    """The first frames of the room's first camera, and what the slow instance says meanwhile."""
    camera = next(iter(room.cameras.values()))
    if camera.source is None:
        raise SystemExit(f'camera "{camera.name}" has no source: give a room whose camera plays a video')
    source = used(camera.source, room)
    slow = ("persons.gradients", "persons.hog", "persons.appearance")
    gradients, hog, appearance = (made(name, room) for name in slow)
    people, boxes, taken = None, None, []
    for number, frame in enumerate(islice(source.process(), frames)):
        if number % every == 0:
            boxes = after(frame, hog.process(frame))
            people = after(frame, appearance.process(frame, gradients.process(frame), boxes))
        taken.append(Shot(stamped(Frame(frame.camera, frame.pixels.copy()), frame.header), people, boxes))
    source.close()
    return taken


def measure(room: Room, taken: list[Shot], particles: int) -> dict[str, Any]:
    """CPU time of the two stages of the fast instance, as figures for users."""
    gradients = made("persons.gradients", room)
    tracker = made("persons.pose_tracker", room, particles=particles)
    cost, persons = np.zeros(2), 0
    for shot in taken:
        began = time.thread_time()
        edges = after(shot.frame, gradients.process(shot.frame))
        found = time.thread_time()
        poses = tracker.process(shot.frame, edges, shot.people, shot.boxes)
        cost += found - began, time.thread_time() - found
        persons += len(poses.person)
    each = 1000 * cost / len(taken)
    return {
        "size": list(next(iter(room.cameras.values())).size),
        "particles": particles,
        "persons": persons / len(taken),
        "frames": len(taken),
        "gradients_ms": each[0],
        "pose_tracker_ms": each[1],
        "frames_per_s": 1000 / each.sum(),
    }


def used(use: StageUse, room: Room) -> Stage:
    """A stage that a room file names, set up; paths are relative to the file's folder."""
    paths = path_parameters(load_stage(use.uses).Params, PathIn)
    params = {name: str(Path(use.folder) / v) if name in paths and v else v for name, v in use.params.items()}
    return made(use.uses, room, **params)


def made(name: str, room: Room, **params: Any) -> Stage:
    """A stage of the room's first camera, set up."""
    stage = load_stage(name)(Context.serving(next(iter(room.cameras.values())), room), **params)
    stage.setup()
    return stage


def after(frame: Frame, message: Any) -> Any:
    """A stage's message with the header of the frame that it is about."""
    assert isinstance(message, Message)
    return stamped(message, frame.header)


if __name__ == "__main__":
    main()
