"""The stages of pose tracking over the first camera of a room, one call after the other, for benchmarks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from followspot import Room, Stage
from followspot.context import Context
from followspot.graph.parameters import path_parameters
from followspot.messages import Message, stamped
from followspot.people import Appearances, Boxes
from followspot.plugins.registry import load_stage
from followspot.room import StageUse
from followspot.stage_params import PathIn
from followspot.tracking import Frame


@dataclass(frozen=True)
class Shot:
    """A frame and the newest messages of the slow instance that are known by then."""

    frame: Frame
    people: Appearances | None
    boxes: Boxes | None


def shots_with_people(room: Room, frames: int, every: int) -> list[Shot]:
    """The first frames of the room's first camera, with the results of the slow instance.

    every: frames between two of the slow instance.
    """
    camera = next(iter(room.cameras.values()))
    if camera.source is None:
        raise SystemExit(f'camera "{camera.name}" has no source: give a room whose camera plays a video')
    source = build_used_stage(camera.source, room)
    slow = ("persons.gradients", "persons.hog", "persons.appearance")
    gradients, hog, appearance = (build_stage(name, room) for name in slow)
    people, boxes, taken = None, None, []
    for number, frame in enumerate(islice(source.process(), frames)):
        if number % every == 0:
            boxes = with_header_of(frame, hog.process(frame))
            people = with_header_of(frame, appearance.process(frame, gradients.process(frame), boxes))
        taken.append(Shot(stamped(Frame(frame.camera, frame.pixels.copy()), frame.header), people, boxes))
    source.close()
    return taken


def build_used_stage(use: StageUse, room: Room) -> Stage:
    """A stage that a room file names, set up; paths are relative to the file's folder."""
    paths = path_parameters(load_stage(use.uses).Params, PathIn)
    params = {name: str(Path(use.folder) / v) if name in paths and v else v for name, v in use.params.items()}
    return build_stage(use.uses, room, **params)


def build_stage(name: str, room: Room, **params: Any) -> Stage:
    """A stage of the room's first camera, set up."""
    stage = load_stage(name)(Context.serving(next(iter(room.cameras.values())), room), **params)
    stage.setup()
    return stage


def with_header_of(frame: Frame, message: Any) -> Any:
    """A stage's message with the header of the frame that it is about."""
    assert isinstance(message, Message)
    return stamped(message, frame.header)
