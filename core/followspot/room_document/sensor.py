"""From one entry of `sensors` in a room document to a sensor."""

from __future__ import annotations

from collections.abc import Mapping

from followspot.errors import Mistake, did_you_mean
from followspot.room import Member, Sensor
from followspot.room_document.parts import stage_use, tags_of, word
from followspot.yaml.form import Form
from followspot.yaml.node import Node

_MOST_RATE = 1e6
"""Highest rate of a sensor, 1/s."""
_KEYS = ("kind", "source", "rate", "mount", "host", "tags")


def sensor_of(name: str, node: Node, room: Form, folder: str | None) -> Sensor:
    """The sensor that an entry describes; notes mistakes. room: the form of the whole document."""
    form = Form(node, f"sensor {name}", _KEYS, room.mistakes)
    twin = room.mapping("cameras").get(name)
    if twin is not None:
        text = f'"{name}" names a sensor and a camera'
        room.mistakes.append(
            Mistake(node.key, text, f"rename one; the camera stands in line {twin.key.line}")
        )
    source = form.get("source")
    use = None if source is None else stage_use(source, f"the source of {name}", folder, room.mistakes)
    rate = form.number("rate", above=0.0, most=_MOST_RATE)
    return Sensor(
        name, word(form, "kind") or "", use, rate, _mount(form, name, room), form.host(), tags_of(form)
    )


def _mount(form: Form, name: str, room: Form) -> Member | None:
    """The target or camera that carries a sensor."""
    node = form.get("mount")
    if node is None:
        return None
    mount = Form(node, f"the mount of {name}", ("target", "camera"), form.mistakes)
    if isinstance(node.value, Mapping) and len(mount.entries) != 1:
        mount.wrong(node, f"the mount of {name} is one target or one camera", "mount: {target: NAME}")
        return None
    noun = "camera" if "camera" in mount.entries else "target"
    carrier, known = mount.text(noun), room.mapping(f"{noun}s")
    if carrier is None or carrier in known:
        return None if carrier is None else Member(f"{noun}s", carrier)
    text = f'sensor {name} is mounted on {noun} "{carrier}", which the room lacks'
    mount.wrong(mount.entries[noun], text, did_you_mean(carrier, known, f"{noun}s"))
    return None
