"""A room with four cameras in its corners, and what networks find of the people in it."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from followspot import Camera, Context, Room
from followspot.people import Boxes
from followspot.points import Points2D
from followspot.room import Member
from followspot_accuracy import PoseTable, pose_truth_of
from followspot_persons.associate.stage import Associate, Outputs
from followspot_sim.actor.points import PersonPoints
from followspot_sim.actor.truth import PoseTruthOfActors

K = np.array([[800.0, 0, 639.5], [0, 800.0, 479.5], [0, 0, 1]])
Set = tuple[tuple[Points2D, Boxes], ...]


def corner_room(half: float = 2.0, height: float = 2.6) -> Room:
    """Cameras that look at the middle, from corners of a square of 2 (half + 0.7) m."""
    cameras = {}
    for number, (x, y) in enumerate([(-1, -1), (1, -1), (1, 1), (-1, 1)]):
        eye = np.array([x * (half + 0.7), y * (half + 0.7), height])
        ahead = np.array([0.0, 0.0, 0.9]) - eye
        ahead /= np.linalg.norm(ahead)
        right = np.cross(ahead, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        R = np.array([right, np.cross(ahead, right), ahead])
        name = f"c{number}"
        cameras[name] = Camera(name, "color", (1280, 960), K, np.zeros(5), R, -R @ eye)
    return Room("corners", cameras=cameras, planes={"floor": np.array([0.0, 0.0, 1.0, 0.0])})


@cache
def crowded(people: int, frames: int, fps: float, seed: int, late: tuple[float, ...] = (0.0,) * 4) -> Any:
    """The room, a set of findings for each frame, and the truth. late: of each camera, s."""
    room = corner_room()
    given = {"people": people, "frames": frames, "fps": fps, "seed": seed, "walking_area": (-2, -2, 2, 2)}
    found = []
    for (name, camera), by in zip(room.cameras.items(), late, strict=True):
        stage = PersonPoints(Context(name, room, Member("cameras", camera.name)), **given, late_by=by)
        stage.setup()
        found.append([(each.points, each.boxes) for each in stage.process()])
    truth = PoseTruthOfActors(Context("truth", room), **given, visibility=False)
    truth.setup()
    return room, list(zip(*found, strict=True)), pose_truth_of(truth.process())


def followed(room: Room, sets: list[Set], kind: str, **params: Any) -> list[Outputs]:
    """What the association says of each set. kind: "points" or "boxes"."""
    stage = Associate(Context("associate", room), **params)
    stage.setup()
    if kind == "points":
        return [stage.process(points=tuple(points for points, _ in each)) for each in sets]
    return [stage.process(boxes=tuple(boxes for _, boxes in each)) for each in sets]


def table(sets: list[Set], outputs: list[Outputs]) -> PoseTable:
    """All poses, at the times of their sets."""
    time, person, pose = [], [], []
    for each, out in zip(sets, outputs, strict=True):
        p = out.poses
        time += [each[0][0].header.time / 1e9] * len(p.person)
        person += p.person.tolist()
        pose += np.column_stack([p.xy, p.height, p.heading, p.pan, p.tilt]).tolist()
    return PoseTable(np.array(time), np.array(person, int), np.reshape(pose, (-1, 6)))
