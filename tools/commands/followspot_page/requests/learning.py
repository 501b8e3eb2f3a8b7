"""Targets learnt on the page: a still picture, a click or a rectangle in it, and the room file."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from followspot import Camera, Room, Target
from followspot.errors import FollowspotError, writing
from followspot.frame_times import to_seconds
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.library.handle import RunHandle
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.room_file import load, update
from followspot.tracking import Frame
from followspot_balls.templates.from_picture import (
    MOST_ALIKE,
    Pick,
    Template,
    likeness,
    template_of,
    with_template,
)
from followspot_page.allowed_requests import Learn
from followspot_page.display.scene import colors
from followspot_page.requests.reply import Reply
from followspot_watch.tap_subscriber import TapSubscriber

_TAP = "followspot.subscription"
"""Sends whole frames, not previews."""
_PICTURE_TIMEOUT = 10.0
"""Seconds for a picture to come."""
_QUALITY = 90
"""Quality of the JPEG that is clicked on, of 100; the target is learnt from the frame itself."""


@dataclass(frozen=True, eq=False)
class Learnt:
    """A target that was learnt and is not written yet; radius: m, None for that of the room file."""

    name: str
    camera: str
    radius: float | None
    template: Template


class Learning:
    """The learning of one browser: the newest still picture, and the newest target learnt from it."""

    def __init__(self) -> None:
        self._still: Frame | None = None
        self._learnt: Learnt | None = None

    def still(self, run: RunHandle, plan: Plan, name: str) -> Reply:
        """Take the next frame of a camera, at full size. Raises FollowspotError if none comes."""
        camera = plan.room.cameras.get(name)
        if camera is None:
            raise FollowspotError(f"there is no camera {name}")
        if camera.kind != "color":
            text = f"{name} shows no colour; learn it from clips: followspot calibrate targets --clips"
            raise FollowspotError(text)
        file = room_file(run, plan)
        known = {target.name: target.radius for target in load(file).targets.values()}
        self._learnt = None
        self._still = frame = next_frame(run, plan, camera)
        height, width = frame.pixels.shape[:2]
        _, jpeg = cv2.imencode(".jpg", frame.pixels, (cv2.IMWRITE_JPEG_QUALITY, _QUALITY))
        about = {"camera": name, "size": [width, height], "targets": known, "file": str(file)}
        return Reply(f"{name} at {to_seconds(frame.header.time):.3f} s", about, jpeg.tobytes())

    def learn(self, run: RunHandle, plan: Plan, asked: Learn) -> Reply:
        """Learn a target from the still picture. Raises FollowspotError, with the remedy on a second line."""
        if self._still is None:
            raise FollowspotError("take a picture first")
        name = self._still.camera
        template = template_of(self._still.pixels, Pick(asked.learn, asked.box, None))
        self._learnt = Learnt(asked.learn, name, asked.radius, template)
        room = load(room_file(run, plan))
        return Reply(f"learnt from {template.pixels} px", described(self._learnt, room))

    def write(self, run: RunHandle, plan: Plan) -> Reply:
        """Write the target that was learnt into the room file. Raises FollowspotError."""
        if self._learnt is None:
            raise FollowspotError("nothing was learnt yet: click on a ball, or drag a rectangle around it")
        file = room_file(run, plan)
        room = load(file)
        target = learnt_target(room, self._learnt)
        with writing(file):
            update(file, targets={**room.targets, target.name: target})
        self._learnt = None
        return Reply(f"{target.name} is in {file}; this run goes on without it, the next run looks for it")


def learnt_target(room: Room, learnt: Learnt) -> Target:
    """The target as the room file will have it. Raises FollowspotError."""
    camera, known = room.cameras.get(learnt.camera), room.targets.get(learnt.name)
    if camera is None:
        raise FollowspotError(f"the room file has no camera {learnt.camera} any more")
    if known is None and learnt.radius is None:
        raise FollowspotError(f"{learnt.name} is a new target: give its radius, in metres")
    return with_template(
        known or Target(learnt.name, learnt.radius or 0.0), camera, learnt.template, learnt.radius
    )


def described(learnt: Learnt, room: Room) -> dict[str, Any]:
    """The learnt target for the browser, and what will be written. Raises FollowspotError.

    hue: degrees; share: of its pixels that have this hue; radius: px; alike: similarity with the templates of
    other targets in this camera, the worst first, and whether the detector would confuse them.
    """
    target = learnt_target(room, learnt)
    template, targets = learnt.template, {**room.targets, learnt.name: target}
    alike = sorted(likeness(targets, [learnt.name], learnt.camera), key=lambda pair: -pair[2])
    peak = int(template.histogram.argmax())
    return {
        "name": learnt.name,
        "camera": learnt.camera,
        "new": learnt.name not in room.targets,
        "color": colors([Target(learnt.name, 1.0, {learnt.camera: template.histogram})])[0],
        "hue": round((peak + 0.5) * 360 / len(template.histogram)),
        "share": round(float(template.histogram[peak]), 3),
        "pixels": template.pixels,
        "center": [round(v, 1) for v in template.center],
        "radius_px": round(float(np.sqrt(template.pixels / np.pi)), 1),
        "area": list(template.area),
        "radius_m": target.radius,
        "alike": [
            {"name": other, "similarity": value, "confused": value >= MOST_ALIKE} for _, other, value in alike
        ],
        "minimum_saturation": template.minimum_saturation,
    }


def room_file(run: RunHandle, plan: Plan) -> Path:
    """The room file of a run on this host. Raises FollowspotError if there is none."""
    metadata = run.metadata()
    files = metadata.source_files
    if metadata.out is None or files is None:
        text = "the room file of this run is not on this host; learn the target where it is"
        raise FollowspotError(f"{text}: followspot calibrate targets --pick")
    if files.room:
        return Path(files.room)
    made = compile_graph(Path(files.graph), cameras=files.cameras, plugin_files=plan.plugin_files)
    if made.room_document is None:
        raise FollowspotError(f"{files.graph} has no room")
    return Path(made.room_document.place.file)


def next_frame(run: RunHandle, plan: Plan, camera: Camera) -> Frame:
    """The next frame that a camera's source sends, (H, W, 3) u8. Raises FollowspotError if none comes."""
    port = frame_port(plan, camera.name)
    deadline = time.monotonic() + _PICTURE_TIMEOUT
    with TapSubscriber(run, {port: Frame}, _TAP) as subscriber:
        for received in subscriber.messages(0.5):
            if received is not None and isinstance(received[1], Frame):
                return _colored(received[1])
            if time.monotonic() > deadline:
                break
    raise FollowspotError(f"no picture of {camera.name} came; if the run is paused, resume or step it")


def frame_port(plan: Plan, camera: str) -> str:
    """The port of the source of a camera's frames. Raises FollowspotError if there is none."""
    for stage in plan.stages:
        its = ports(load_stage(stage.uses))
        for port in its.outputs if its.source and stage.camera == camera else ():
            if issubclass(port.type, Frame):
                return f"{stage.name}.{port.name}"
    raise FollowspotError(f"no stage of this run sends pictures of {camera}")


def _colored(frame: Frame) -> Frame:
    if frame.pixels.ndim != 3 or frame.pixels.shape[2] != 3 or frame.pixels.dtype != np.uint8:
        raise FollowspotError(f"{frame.camera} sends no colour pictures")
    return frame
