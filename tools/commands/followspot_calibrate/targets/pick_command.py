"""`followspot calibrate targets --pick`: targets from single pictures of a room's cameras."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from followspot import Camera, Context, Room, Target
from followspot.errors import InputError, did_you_mean, writing
from followspot.messages import Array
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.plugins.registry import load_stage
from followspot.room_file import load, update
from followspot_balls.templates.from_picture import (
    MOST_ALIKE,
    Pick,
    Template,
    likeness,
    template_of,
    with_template,
)
from followspot_calibrate.targets.learning import refuse_radius

GRID = 100
"""Distance of the lines in the picture to look at, px."""
_WORDS = re.compile(r"(?P<name>[A-Za-z0-9_-]+)(?:=(?P<numbers>-?\d+(?:,-?\d+)*))?(?:@(?P<frame>\d+))?")


def pick_targets(args: argparse.Namespace, usual: float) -> int:
    """Learn the picked targets and update the room file; returns the exit code. Raises InputError.

    usual: radius, m, if neither the user nor the room file gives it.
    """
    refuse_radius(args.radius)
    room = load(args.room)
    camera = _camera(room, args.camera)
    picks = [read_pick(text) for text in args.pick]
    _refuse_some_of(picks)
    for pick in picks:
        if not pick.box:
            print(_to_look_at(args.room, camera, pick))
            return 0
    with printed_to_stderr(True):
        found = {pick.name: template_of(picture_of(camera, pick.frame), pick) for pick in picks}
    targets = dict(room.targets)
    for name, template in found.items():
        target = targets.get(name, Target(name, args.radius or usual))
        targets[name] = with_template(target, camera, template, args.radius)
    with writing(args.room):
        update(args.room, targets=targets)
    alike = [pair for pair in likeness(targets, found, camera.name) if pair[2] >= MOST_ALIKE]
    print(_as_json(found, alike) if args.json else _summary(args.room, camera, found, alike))
    return 0


def read_pick(text: str) -> Pick:
    """NAME, NAME=X,Y or NAME=X,Y,WIDTH,HEIGHT, each with @FRAME if it is wanted. Raises InputError."""
    found = _WORDS.fullmatch(text)
    numbers = tuple(map(int, found["numbers"].split(","))) if found and found["numbers"] else ()
    if found is None or len(numbers) not in (0, 2, 4):
        remedy = "write NAME=X,Y, NAME=X,Y,WIDTH,HEIGHT, or NAME alone to see a picture, each with @FRAME"
        raise InputError.of(f"--pick {text} names no place in a picture", remedy)
    return Pick(found["name"], numbers, None if found["frame"] is None else int(found["frame"]))


def _refuse_some_of(picks: Sequence[Pick]) -> None:
    """Raises InputError for picks of which some would not be learnt."""
    names = [pick.name for pick in picks]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError.of(f"--pick {twice} is given twice", "give one place for each target")
    placeless = next((pick.name for pick in picks if not pick.box), None)
    if placeless is not None and len(picks) > 1:
        text = f"--pick {placeless} has no place, so it shows a picture and nothing is learnt"
        raise InputError.of(text, "give it alone, or give it a place, too")


def picture_of(camera: Camera, frame: int | None) -> Array:
    """A picture of the camera's recording, (H, W, 3) u8; None for the middle one. Raises InputError."""
    if camera.source is None:
        raise InputError.of(f"camera {camera.name} has no source", "name its video in the room file")
    stage_class = load_stage(camera.source.uses)
    if stage_class.live:
        raise InputError.of(f"camera {camera.name} is a live camera", "record it: followspot record")
    folder = Path(camera.source.folder)
    params: dict[str, Any] = dict(camera.source.params)
    params = {k: str(folder / v) if k in ("path", "times") else v for k, v in params.items()}
    stage = stage_class(Context.serving(camera, name=camera.name), **params)
    stage.setup()
    try:
        length = stage.length() or 1
        wanted = length // 2 if frame is None else frame
        frames = 0
        for message in stage.process():
            if frames == wanted:
                return np.array(message.pixels)
            frames += 1
    finally:
        stage.close()
    raise InputError.of(f"{camera.name} has no frame {wanted}", f"it has {frames}, counted from 0")


def _camera(room: Room, name: str | None) -> Camera:
    """The named camera, or the only one in colour. Raises InputError."""
    colored = [camera for camera in room.cameras.values() if camera.kind == "color"]
    if name is not None and name not in room.cameras:
        remedy = did_you_mean(name, room.cameras, "cameras")
        raise InputError.of(f'--camera: there is no camera "{name}"', remedy)
    chosen = [camera for camera in colored if name in (None, camera.name)]
    if len(chosen) != 1:
        known = ", ".join(camera.name for camera in colored) or "none in colour"
        raise InputError.of("--pick needs one colour camera", f"name it by --camera; cameras: {known}")
    return chosen[0]


def _to_look_at(room_file: Path, camera: Camera, pick: Pick) -> str:
    """Write a picture with coordinates, and say what to do with it."""
    with printed_to_stderr(True):
        picture = picture_of(camera, pick.frame)
    path = room_file.with_suffix(f".{camera.name}.png")
    with writing(path):
        path.write_bytes(cv2.imencode(".png", with_grid(picture))[1].tobytes())
    at = "" if pick.frame is None else f"@{pick.frame}"
    return (
        f"look at {path}; is the ball there? then give its middle: "
        f"followspot calibrate targets --room {room_file} --pick {pick.name}=X,Y{at}\n"
        f"or its rectangle: --pick {pick.name}=X,Y,WIDTH,HEIGHT{at}; another picture: {pick.name}@FRAME"
    )


def with_grid(picture: Array) -> Array:
    """The picture with a line every `GRID` px, and its coordinate."""
    drawn = picture.copy()
    height, width = picture.shape[:2]
    for x in range(GRID, width, GRID):
        cv2.line(drawn, (x, 0), (x, height), (255, 255, 255), 1)
        cv2.putText(drawn, str(x), (x + 2, 12), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (255, 255, 255), 1)
    for y in range(GRID, height, GRID):
        cv2.line(drawn, (0, y), (width, y), (255, 255, 255), 1)
        cv2.putText(drawn, str(y), (2, y - 2), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (255, 255, 255), 1)
    return drawn


def _summary(
    room_file: Path, camera: Camera, found: dict[str, Template], alike: list[tuple[str, str, float]]
) -> str:
    lines = [
        f"{name}: {template.pixels} px in {camera.name}, taken for it from {template.area[0]:.0f} "
        f"to {template.area[1]:.0f} px"
        for name, template in found.items()
    ]
    lines += [f"warning: {a} and {b} look alike (similarity {value})" for a, b, value in alike]
    command = f"followspot run graphs/single_camera.yaml --room {room_file}"
    lines.append(f"written to {room_file}; next: {command}")
    least = [template.minimum_saturation for template in found.values()]
    if all(least):
        strong = f"--set color.minimum_saturation={min(filter(None, least))}"
        lines.append(f"if paler things of its hue are found, skin or wood: {strong}")
    return "\n".join(lines)


def _as_json(found: dict[str, Template], alike: list[tuple[str, str, float]]) -> str:
    targets = {name: {"pixels": one.pixels, "area": list(one.area)} for name, one in found.items()}
    return json.dumps({"targets": targets, "alike": [list(pair) for pair in alike]})
