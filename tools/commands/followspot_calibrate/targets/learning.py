"""Templates of targets from clips: one target in each, seen by one camera after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot import Camera, Room, Target
from followspot.errors import FollowspotError, InputError
from followspot.graph.checks.lengths import LARGEST_RADIUS, SMALLEST_RADIUS
from followspot.messages import Array
from followspot_balls.templates.from_clip import ColorSpots, color_spots, color_template, learn_infrared
from followspot_calibrate.clips import MOST_FRAMES, read_frames
from followspot_cameras.recordings import find_recordings


@dataclass(frozen=True)
class Learnt:
    """The result of learning from one clip: the template's parts for this camera, or why there are none.

    spots: the target in each frame, if the camera shows colour.
    """

    camera: Camera
    frames: int
    hue_histogram: Array | None = None
    gray: tuple[float, float] | None = None
    area: tuple[float, float] | None = None
    spots: ColorSpots | None = None
    problem: str = ""


def learn(clips: Path, room: Room) -> Iterator[Learnt]:
    """Learn one target from the clips of each camera of the room."""
    recordings = find_recordings(clips, room.cameras)
    for name, camera in room.cameras.items():
        if name in recordings:
            yield learn_from(recordings[name], camera)
        else:
            yield Learnt(camera, 0, problem=f"there is no clip {clips / name}.mkv; record one")


def learn_from(recording: Path, camera: Camera) -> Learnt:
    """Learn from a clip; the problem names the remedy if it has no usable target."""
    try:
        frames = read_frames(recording, camera, MOST_FRAMES)
    except FollowspotError as error:
        return Learnt(camera, 0, problem=str(error))
    try:
        if camera.kind == "color":
            spots = color_spots(frames)
            histogram, area = np.round(color_template(spots), 6), spots.extremes
            return Learnt(camera, len(frames), hue_histogram=histogram, area=area, spots=spots)
        gray, area = learn_infrared(frames)
        return Learnt(camera, len(frames), gray=gray, area=area)
    except ValueError as error:
        return Learnt(camera, len(frames), problem=f"{error}; move the target through the camera's view")


def refuse_radius(radius: float | None) -> None:
    """Raises InputError for a radius that no target has in metres, as if it were written in millimetres."""
    if radius is not None and not SMALLEST_RADIUS <= radius <= LARGEST_RADIUS:
        text = f"--radius {radius:g} is no radius of a target in metres"
        raise InputError.of(text, f"from {SMALLEST_RADIUS:g} to {LARGEST_RADIUS:g}; of a ball of 50 mm 0.05")


def with_templates(target: Target, radius: float | None, learnt: Sequence[Learnt]) -> Target:
    """The target with this radius (m; None: its own) and templates of what was learnt only."""
    good = [one for one in learnt if not one.problem]
    return Target(
        name=target.name,
        radius=target.radius if radius is None else radius,
        hue_histogram={s.camera.name: s.hue_histogram for s in good if s.hue_histogram is not None},
        gray={s.camera.name: s.gray for s in good if s.gray is not None},
        area={s.camera.name: s.area for s in good if s.area is not None},
    )
