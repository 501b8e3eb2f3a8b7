"""Recordings of a simulated room with people: lossless videos, and the true poses as tables."""

from __future__ import annotations

import contextlib
import csv
from pathlib import Path

import numpy as np

from followspot import Camera, InputError, Room
from followspot.errors import Mistake, writing
from followspot.notes import note
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.picture import ActorPicture
from followspot_sim.actor.scene import Play, stage_of
from followspot_sim.actor.visibility import VisibilityOfActors
from followspot_sim.video import finite, new_video

STAGE = "sim.person_camera"
COLUMNS = (
    *("frame", "time", "person", "x", "y", "phi", "r", "z_head_top", "torso_heading_room"),
    *("torso_heading", "head_pan", "head_tilt", "visible_upper"),
)


def has_people(room: Room) -> bool:
    """Whether a camera of the room simulates people."""
    return any(camera.source and camera.source.uses == STAGE for camera in room.cameras.values())


def actor_parameters_of(room: Room, *, frames: int | None = None, seed: int | None = None) -> ActorParams:
    """The parameters that the room gives to its simulated cameras, with some replaced.

    Raises InputError if a camera is not simulated, if two cameras differ, and for a value out of range.
    """
    given = [(c.source.uses, dict(c.source.params)) for c in room.cameras.values() if c.source]
    if len(given) < len(room.cameras) or any(use != given[0] or use[0] != STAGE for use in given):
        text = "all cameras of a simulated room with people have one source with the same parameters"
        raise InputError([Mistake(None, text, f"give each `source: {{uses: {STAGE}, with: ...}}`")])
    replaced = {k: v for k, v in (("frames", frames), ("seed", seed)) if v is not None}
    return finite(ActorParams, **{**given[0][1], **replaced})


def record_people(room: Room, params: ActorParams, folder: Path) -> None:
    """Write `folder`/CAMERA.mkv and `folder`/CAMERA_gt.csv. Raises FollowspotError if it cannot."""
    note(f"simulate: {len(room.cameras)} videos of {params.frames} frames")
    folder.mkdir(parents=True, exist_ok=True)
    for camera in room.cameras.values():
        with contextlib.ExitStack() as files:
            path = folder / f"{camera.name}.mkv"
            video = files.enter_context(new_video(path, params.fps, camera.size, params.frames))
            truth = folder / f"{camera.name}_gt.csv"
            files.enter_context(writing(truth))
            table = files.enter_context(truth.open("w", newline="", encoding="utf-8"))
            rows = csv.writer(table)
            rows.writerow(COLUMNS)
            picture, visibility = ActorPicture(params, camera), VisibilityOfActors(params, camera)
            pixels = np.empty(picture.shape, np.uint8)
            for frame in range(params.frames):
                picture.render(frame, pixels)
                video.write(pixels)
                play = stage_of(params).play(frame)
                rows.writerows(
                    _rows(camera, frame, frame / params.fps, play, visibility.visible(play).tolist())
                )


def _rows(camera: Camera, frame: int, time: float, play: Play, visible: list[float]) -> list[list[object]]:
    """One row a person; direction, distance and torso heading as this camera sees them."""
    x0, y0 = camera.center[:2].tolist()
    ahead = float(np.arctan2(camera.rotation[2, 1], camera.rotation[2, 0]))
    found: list[list[object]] = []
    for person, stance in enumerate(play.stances):
        away = float(np.arctan2(stance.y - y0, stance.x - x0))
        numbers = (
            *(stance.x, stance.y, _wrapped(away - ahead), float(np.hypot(stance.x - x0, stance.y - y0))),
            *(float(play.heights[person]), stance.heading, _wrapped(stance.heading - away - np.pi)),
            *(stance.pan, stance.tilt, visible[person]),
        )
        found.append([frame, f"{time:.6f}", person + 1, *(f"{value:.5f}" for value in numbers)])
    return found


def _wrapped(angle: float) -> float:
    """The angle from -pi to pi, rad."""
    return float(np.mod(angle + np.pi, 2 * np.pi) - np.pi)
