"""What `followspot calibrate targets` does."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from followspot import Room, Target
from followspot.errors import FollowspotError, InputError, Mistake
from followspot.room_file import load, update
from followspot_calibrate.targets.learning import Lesson, clips_of, learn, taught


def calibrate_targets(
    room_file: Path, clips: Path, radius: float | None, usual: float, *, as_json: bool
) -> int:
    """Learn all targets, update the room file, report; returns the exit code.

    radius, usual: m, as given, and where neither the user nor the room file knows it. A clip that teaches
    nothing is a warning. Raises FollowspotError for targets that no camera saw; the others are written.
    """
    if radius is not None and not radius > 0:
        text = f"--radius {radius:g} is not positive"
        raise InputError([Mistake(None, text, "give metres, for example 0.05")])
    room = load(room_file)
    report = {folder.name: learn_aloud(folder, room) for folder in clips_of(clips)}
    failed = [name for name, lessons in report.items() if all(lesson.problem for lesson in lessons)]
    learnt = {
        name: taught(room.targets.get(name, Target(name, usual)), radius, lessons)
        for name, lessons in report.items()
        if name not in failed
    }
    try:
        update(room_file, targets={**room.targets, **learnt})
    except OSError as error:
        raise FollowspotError(f"{room_file} cannot be written: {error.strerror}") from None
    print(_as_json(report) if as_json else summary(report))
    if failed:
        raise FollowspotError(f"no camera saw {', '.join(failed)}; {room_file} has the other targets")
    return 0


def learn_aloud(folder: Path, room: Room) -> list[Lesson]:
    """The lessons of one target, with progress and warnings on the way."""
    lessons = []
    for number, lesson in enumerate(learn(folder, room), 1):
        lessons.append(lesson)
        if sys.stderr.isatty():
            print(f"\r{folder.name}: camera {number} of {len(room.cameras)} ", end="", file=sys.stderr)
        if lesson.problem:
            print(f"warning: {folder.name}, {lesson.camera.name}: {lesson.problem}", file=sys.stderr)
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
    return lessons


def summary(report: Mapping[str, Sequence[Lesson]]) -> str:
    """A table: one line per target and camera."""
    head = ("target", "camera", "frames", "area", "template")
    lines = [head, *(_line(name, one) for name, lessons in report.items() for one in lessons)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    rows = ([cell.ljust(width) for cell, width in zip(line, widths, strict=True)] for line in lines)
    return "\n".join("  ".join(row).rstrip() for row in rows)


def _line(name: str, one: Lesson) -> Sequence[str]:
    area = f"{one.area[0]:.0f}-{one.area[1]:.0f} px" if one.area else "-"
    template = "nothing learnt"
    if one.hue_histogram is not None:
        template = f"hue {one.hue_histogram.argmax() * 360 // len(one.hue_histogram)} deg"
    elif one.gray is not None:
        template = f"gray {one.gray[0]:.0f}-{one.gray[1]:.0f}"
    return name, one.camera.name, str(one.frames), area, template


def _as_json(report: Mapping[str, Sequence[Lesson]]) -> str:
    return json.dumps(
        {name: {one.camera.name: _fields(one) for one in lessons} for name, lessons in report.items()}
    )


def _fields(one: Lesson) -> dict[str, Any]:
    histogram = None if one.hue_histogram is None else one.hue_histogram.tolist()
    found = {"hue_histogram": histogram, "gray": one.gray, "area": one.area}
    return {"frames": one.frames, **found, "problem": one.problem}
