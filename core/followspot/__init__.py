"""followspot: plugin-based dataflow for room-scale multi-camera tracking.

What plugin authors import: stages (`Stage`, `StageParams`, `Field`, `Latest`, `Joined`), messages
(`Message`, `column`, `at`) and the room. The message types of tracking stand in `followspot.tracking`.
Nothing is imported before it is asked for, so that the command line answers at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from followspot.errors import FollowspotError, InputError
    from followspot.messages import Array, Header, Message, at, column
    from followspot.room import Camera, Room, Target
    from followspot.stage import (
        Context,
        Field,
        InputAddress,
        InputDevice,
        InputPath,
        Joined,
        Latest,
        OutputHost,
        OutputPath,
        Source,
        Stage,
        StageParams,
    )

_HOME = {
    "FollowspotError": "errors",
    "InputError": "errors",
    "Array": "messages",
    "Header": "messages",
    "Message": "messages",
    "at": "messages",
    "column": "messages",
    "Camera": "room",
    "Room": "room",
    "Target": "room",
    "Context": "stage",
    "Field": "stage",
    "InputAddress": "stage",
    "InputDevice": "stage",
    "InputPath": "stage",
    "Joined": "stage",
    "Latest": "stage",
    "OutputHost": "stage",
    "OutputPath": "stage",
    "Source": "stage",
    "Stage": "stage",
    "StageParams": "stage",
}

__all__ = [
    "Array",
    "Camera",
    "Context",
    "Field",
    "FollowspotError",
    "Header",
    "InputAddress",
    "InputDevice",
    "InputError",
    "InputPath",
    "Joined",
    "Latest",
    "Message",
    "OutputHost",
    "OutputPath",
    "Room",
    "Source",
    "Stage",
    "StageParams",
    "Target",
    "at",
    "column",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"followspot.{_HOME[name]}"), name)
    raise AttributeError(f"module 'followspot' has no attribute {name!r}")
