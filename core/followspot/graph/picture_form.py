"""Whether the sources of cameras give what the kinds of the cameras promise."""

from __future__ import annotations

from followspot.errors import Mistake
from followspot.graph.instances import Instance
from followspot.ports import ports
from followspot.room import Room
from followspot.stage import Stage
from followspot.tracking import DepthImage, Frame

GIVES = {"color": Frame, "infrared": Frame, "depth": DepthImage}
"""The message type of a camera's picture by its kind; cameras of other kinds may give anything."""


def check_picture(instance: Instance, stage: type[Stage], room: Room, mistakes: list[Mistake]) -> None:
    """Note a source that gives frames for a depth camera, or depth images for another one."""
    member = instance.member
    camera = room.cameras.get(member.name) if member is not None and member.set == "cameras" else None
    if camera is None or not ports(stage).source:
        return
    given = {port.type for port in ports(stage).outputs} & {Frame, DepthImage}
    wanted = GIVES.get(camera.kind)
    if given and wanted is not None and wanted not in given:
        names = ", ".join(kind.__name__ for kind in given)
        text = f'camera "{camera.name}" is {camera.kind}, and its source {instance.uses} gives {names}'
        remedy = f"a source of {wanted.__name__}, or another kind of camera"
        mistakes.append(Mistake(instance.uses_place, text, remedy))
