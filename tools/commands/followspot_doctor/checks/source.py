"""The source that a room declares for a camera or a sensor, tried alone."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from followspot.context import Context
from followspot.errors import FollowspotError
from followspot.graph.camera_kind import source_for
from followspot.graph.parameters import path_parameters
from followspot.messages import Message
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.plugins.registry import PluginError, load_stage
from followspot.room import Camera, Member, Room, Sensor
from followspot.stage import Stage
from followspot.stage_params import PathIn
from followspot_doctor.finding import Finding, fine, wrong

TIMEOUT = 6.0
"""Seconds that a source has to deliver what is wanted of it."""
T = TypeVar("T")
Take = Callable[[Iterator[Message]], T]
"""Takes what is wanted of the messages of a source."""


@dataclass(frozen=True)
class Tried(Generic[T]):
    """finding: why there is nothing to take, else None; taken: None if nothing came; said: by the source."""

    finding: Finding | None
    taken: T | None = None
    said: str = ""


def tried(
    device: Camera | Sensor, room: Room, take: Take[T], example: str, timeout: float = TIMEOUT
) -> Tried[T]:
    """Run the source of a camera or sensor. example: a source, if it has none; timeout: s."""
    if device.host:
        return Tried(fine(device.name, f"is on {device.host}: run followspot doctor there"))
    use = device.source
    if use is None:
        return Tried(wrong(device.name, "has no source", example))
    member = Member("cameras" if isinstance(device, Camera) else "sensors", device.name)
    uses = source_for(use.uses, member, room)
    try:
        stage = load_stage(uses)
        params = dict(use.params)
        for name in path_parameters(stage.Params, PathIn):
            if name in params:
                params[name] = str(Path(use.folder) / str(params[name]))
                if not Path(params[name]).exists():
                    text = f"{params[name]} does not exist"
                    return Tried(wrong(device.name, text, "mend the path in the room file"))
        with TemporaryFolder("doctor") as out:
            warnings: list[str] = []
            context = Context(device.name, room, member=member, out=out.path, warn=warnings.append)
            taken = _taken(stage(context, **params), take, timeout)
    except PluginError as error:
        return Tried(wrong(device.name, error.problem, str(error.remedy)))
    except FollowspotError as error:
        return Tried(wrong(device.name, " ".join(str(error).split()), "see the message"))
    except Exception as error:  # the code of a plugin may do anything
        text = " ".join(f"{uses}: {type(error).__name__}: {error}".split())
        return Tried(wrong(device.name, text[:300], "mend its source in the room file"))
    said = "; ".join(dict.fromkeys(warnings)) or ", ".join(f"{k} {v}" for k, v in use.params.items())
    return Tried(None, taken, said)


def _taken(source: Stage, take: Take[T], timeout: float) -> T | None:
    """The messages that came, the error of the stage, or None after a while; closes the stage."""
    result: list[Any] = []

    def work() -> None:
        try:
            source.setup()
            stream = source.process()
            result.append(take(stream))
            stream.close()
        except Exception as error:
            result.append(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(timeout)
    if not thread.is_alive():
        source.close()
    found = result[0] if result else None
    if isinstance(found, Exception):
        raise found
    return found
