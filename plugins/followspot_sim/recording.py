"""Recordings of a simulated room: lossless videos, and the ground truth as a table."""

from __future__ import annotations

import contextlib
import csv
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from followspot import Array, Camera, InputError, Room
from followspot.errors import Mistake, writing
from followspot.geometry import project
from followspot.notes import note
from followspot_sim.parameters import CameraParams, SimParams
from followspot_sim.rendering.picture import Picture
from followspot_sim.video import finite, new_video
from followspot_sim.visibility import truth_flags, visible_fraction
from followspot_sim.world import Scene, setting, world_of

CLIP_FRAMES = 20
"""Length of a template clip."""
COLUMNS = ("frame", "time", "object", "x", "y", "z", "hidden", "trackable", "pair")


def parameters_of(room: Room, *, frames: int | None = None, seed: int | None = None) -> SimParams:
    """The parameters that the room gives to its simulated cameras, with some replaced.

    They differ in their clock offsets alone. Raises InputError if a camera is not simulated, if two cameras
    differ otherwise, and for a value out of range.
    """
    given = [(c.source.uses, dict(c.source.params)) for c in room.cameras.values() if c.source]
    shared = [(use, {k: v for k, v in values.items() if k != "clock_offset"}) for use, values in given]
    if len(shared) < len(room.cameras) or any(use != shared[0] or use[0] != "sim.camera" for use in shared):
        text = "all cameras of a simulated room have one source with the same parameters but clock_offset"
        raise InputError([Mistake(None, text, "give each `source: {uses: sim.camera, with: ...}`")])
    values = shared[0][1] if shared else {}
    values.update({k: v for k, v in (("frames", frames), ("seed", seed)) if v is not None})
    for _, own in given:
        finite(CameraParams, **{**own, **values})
    return finite(SimParams, **values)


def clock_offset_of(camera: Camera) -> float:
    """How much later than its frames' times a simulated camera takes its pictures, s."""
    return float(camera.source.params.get("clock_offset", 0.0)) if camera.source else 0.0


def record(room: Room, params: SimParams, folder: Path) -> None:
    """Write `folder`/CAMERA.mkv and `folder`/truth.csv. Raises FollowspotError if it cannot."""
    note(f"simulate: {len(room.cameras)} videos of {params.frames} frames")
    write_videos(room, params, folder)
    note("simulate: truth.csv")
    write_truth(room, params, folder / "truth.csv")


def record_templates(room: Room, params: SimParams, folder: Path, frames: int | None) -> None:
    """Write `folder`/TARGET/CAMERA.mkv for each target alone. Raises FollowspotError as :func:`record`."""
    for name in room.targets:
        clip = params.model_copy(update={"only_target": name, "frames": frames or CLIP_FRAMES})
        note(f"simulate: {name}: {len(room.cameras)} clips of {clip.frames} frames")
        write_videos(room, clip, folder / name)


def write_videos(room: Room, params: SimParams, folder: Path) -> None:
    """All frames of all cameras as FFV1, which loses nothing. Raises FollowspotError."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = [Picture(params, room, c, clock_offset_of(c)) for c in room.cameras.values()]
    buffers = [np.empty(picture.shape, np.uint8) for picture in pictures]
    with contextlib.ExitStack() as open_videos:
        videos = [
            open_videos.enter_context(
                new_video(folder / f"{camera.name}.mkv", params.fps, camera.size, params.frames)
            )
            for camera in room.cameras.values()
        ]
        for frame in range(params.frames):
            for picture, pixels, video in zip(pictures, buffers, videos, strict=True):
                picture.render(frame, pixels)
                video.write(pixels if pixels.shape[2] == 3 else cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR))


def write_truth(room: Room, params: SimParams, path: Path) -> None:
    """One row per frame and target, with columns of their own for each camera.

    For camera i these are the projected centre `ci_u, ci_v` (px, with distortion) and the visible
    share `ci_vis`. Raises FollowspotError.
    """
    world = world_of(setting(params, room))
    radii = np.array([t.radius for t in room.targets.values()])
    cameras = list(room.cameras.values())
    with writing(path), path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow([*COLUMNS, *(f"c{i}_{q}" for i in range(len(cameras)) for q in ("u", "v", "vis"))])
        for frame in range(params.frames):
            scene = world.scene(frame)
            seen = visible_fraction(cameras, scene, radii)
            rows.writerows(_rows(frame, scene, list(room.targets), cameras, seen))


def _rows(
    frame: int, scene: Scene, targets: Sequence[str], cameras: Sequence[Camera], seen: Array
) -> list[list[object]]:
    flags = np.array(truth_flags(seen, cameras)).astype(int)
    pixel = np.array([project(c, scene.balls) for c in cameras])
    return [
        [
            frame,
            f"{scene.time:.6f}",
            targets[k],
            *(f"{v:.6f}" for v in scene.balls[k]),
            *flags[:, k],
            *(f"{v:.3f}" for i in range(len(cameras)) for v in (*pixel[i, k], seen[i, k])),
        ]
        for k in range(len(targets))
        if not np.isnan(scene.balls[k, 0])
    ]
