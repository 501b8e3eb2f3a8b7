"""Recordings of a simulated room: lossless videos, and the ground truth as a table."""

from __future__ import annotations

import csv
import sys
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pydantic

from followspot import Array, Camera, FollowspotError, InputError, Room
from followspot.errors import Mistake
from followspot.geometry import project
from followspot_sim.parameters import SimParams
from followspot_sim.picture import Picture
from followspot_sim.visibility import judge, visible_fraction
from followspot_sim.world import Scene, setting, world_of

CLIP_FRAMES = 20
"""Length of a template clip."""
COLUMNS = ("frame", "time", "object", "x", "y", "z", "hidden", "trackable", "pair")


def parameters_of(room: Room, *, frames: int | None = None, seed: int | None = None) -> SimParams:
    """The parameters that the room gives to its simulated cameras, with some replaced.

    Raises InputError where a camera is not simulated, where two cameras differ, and for a value out of range.
    """
    given = [(c.source.uses, dict(c.source.params)) for c in room.cameras.values() if c.source]
    if len(given) < len(room.cameras) or any(use != given[0] or use[0] != "sim.camera" for use in given):
        text = "all cameras of a simulated room have one source with the same parameters"
        raise InputError([Mistake(None, text, "give each `source: {uses: sim.camera, with: ...}`")])
    values = given[0][1] if given else {}
    values.update({k: v for k, v in (("frames", frames), ("seed", seed)) if v is not None})
    try:
        params = SimParams(**values)
    except pydantic.ValidationError as error:
        wrong = [Mistake(None, f"{'.'.join(map(str, e['loc']))}: {e['msg']}", "") for e in error.errors()]
        raise InputError(wrong) from None
    if params.frames == 0:
        raise InputError([Mistake(None, "this room never ends", "say how many frames: --frames 600")])
    return params


def record(room: Room, params: SimParams, folder: Path) -> None:
    """Write `folder`/CAMERA.mkv and `folder`/truth.csv. Raises FollowspotError where it cannot."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, camera in enumerate(room.cameras.values()):
        _progress(f"{camera.name}.mkv ({number + 1} of {len(room.cameras)}, {params.frames} frames)")
        write_video(Picture(params, room, camera), params, folder / f"{camera.name}.mkv")
    _progress("truth.csv")
    write_truth(room, params, folder / "truth.csv")


def record_templates(room: Room, params: SimParams, folder: Path, frames: int | None) -> None:
    """Write `folder`/TARGET/CAMERA.mkv for each target alone. Raises FollowspotError as :func:`record`."""
    for name in room.targets:
        clip = params.model_copy(update={"alone": name, "frames": frames or CLIP_FRAMES})
        (folder / name).mkdir(parents=True, exist_ok=True)
        _progress(f"{name}: {len(room.cameras)} clips of {clip.frames} frames")
        for camera in room.cameras.values():
            write_video(Picture(clip, room, camera), clip, folder / name / f"{camera.name}.mkv")


def write_video(picture: Picture, params: SimParams, path: Path) -> None:
    """All frames of one camera as FFV1, which loses nothing. Raises FollowspotError."""
    width, height = picture.camera.size
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"FFV1"), params.fps, (width, height), True)
    if not video.isOpened():
        raise FollowspotError(f"{path}: cannot write a video; is the folder writable and the disk not full?")
    try:
        pixels = np.empty(picture.shape, np.uint8)
        for frame in range(params.frames):
            picture.render(frame, pixels)
            video.write(pixels if pixels.shape[2] == 3 else cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR))
    finally:
        video.release()


def write_truth(room: Room, params: SimParams, path: Path) -> None:
    """One row per frame and target, with columns of their own for each camera.

    For camera i these are the projected centre `ci_u, ci_v` (px, with distortion) and the visible
    share `ci_vis`.
    """
    world = world_of(setting(params, room))
    radii = np.array([t.radius for t in room.targets.values()])
    cameras = list(room.cameras.values())
    color = np.array([c.kind == "color" for c in cameras], bool)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow([*COLUMNS, *(f"c{i}_{q}" for i in range(len(cameras)) for q in ("u", "v", "vis"))])
        for frame in range(params.frames):
            scene = world.scene(frame)
            seen = visible_fraction(cameras, scene, radii)
            rows.writerows(_rows(frame, scene, list(room.targets), cameras, seen, color))


def _rows(
    frame: int, scene: Scene, targets: Sequence[str], cameras: Sequence[Camera], seen: Array, color: Array
) -> list[list[object]]:
    verdicts = np.array(judge(seen, color)).astype(int)
    pixel = np.array([project(c, scene.balls) for c in cameras])
    return [
        [
            frame,
            f"{scene.time:.6f}",
            targets[k],
            *(f"{v:.6f}" for v in scene.balls[k]),
            *verdicts[:, k],
            *(f"{v:.3f}" for i in range(len(cameras)) for v in (*pixel[i, k], seen[i, k])),
        ]
        for k in range(len(targets))
        if not np.isnan(scene.balls[k, 0])
    ]


def _progress(text: str) -> None:
    print(f"simulate: {text}", file=sys.stderr)  # noqa: T201  # a command's progress, not a frame's
