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
from typing import Any

import cv2
import numpy as np

from benching.person_stages import Shot, build_stage, shots_with_people, with_header_of
from followspot import Room
from followspot.room_file import load
from scripting import options_of


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
    figures = measure(room, shots_with_people(room, given.frames, given.every), given.particles)
    if given.json:
        print(json.dumps(figures))
        return
    print(
        f"{figures['frames_per_s']:.1f} frames/s of {figures['size'][0]} x {figures['size'][1]} on one core, "
        f"{figures['particles']} particles a person, {figures['persons']:.1f} persons a frame: "
        f"gradients {figures['gradients_ms']:.1f} ms, pose_tracker {figures['pose_tracker_ms']:.1f} ms"
    )


def measure(room: Room, taken: list[Shot], particles: int) -> dict[str, Any]:
    """CPU time of the two stages of the fast instance, as figures for users."""
    gradients = build_stage("persons.gradients", room)
    tracker = build_stage("persons.pose_tracker", room, particles=particles)
    cost, persons = np.zeros(2), 0
    for shot in taken:
        began = time.thread_time()
        edges = with_header_of(shot.frame, gradients.process(shot.frame))
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


if __name__ == "__main__":
    main()
