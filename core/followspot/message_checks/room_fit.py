"""Checks that a message fits the room: its cameras, targets and indices.

A message that keeps its contract may still name cameras or targets that do not exist. The sending worker
checks that once, so that the same messages are refused in every placement, and a worker that gets a message
from another one checks it again, so that stages can look them up without checks.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial

import numpy as np

from followspot.columns import Column
from followspot.messages import Array, Message
from followspot.people import Poses
from followspot.room import Room
from followspot.tracking import STATES

FitCheck = Callable[[Message], str]
"""Check of a message; returns the reason why it does not fit the room, "" if it fits."""


def fit_check(kind: type[Message], room: Room, camera: str | None = None) -> FitCheck | None:
    """The check for messages of this type; None if they need none.

    camera: of the sending stage, if it serves one; its messages may name that camera only.

    Fields `camera` and `cameras` name cameras of the room, sizes `H`, `W` and `C` are those of the camera's
    pictures, `T` is the number of targets, and columns that are declared with `refers` lie within what they
    index.
    """
    asked: list[FitCheck] = []
    scalars = dict(kind.scalars)
    if room.cameras and scalars.get("camera") is str:
        fused = [""] if kind is Poses else []
        known = frozenset([camera] if camera is not None else [*room.cameras, *fused])
        asked.append(partial(_camera, known))
        pictures = (column.name for column in kind.columns if column.shape[:2] == ("H", "W"))
        asked += (partial(_pictured, name, room) for name in pictures)
    if room.cameras and scalars.get("cameras") == tuple[str, ...]:
        asked.append(partial(_cameras, frozenset(room.cameras)))
    sized = next((column for column in kind.columns if "T" in column.shape), None)  # others have its T
    if room.targets and sized is not None:
        asked.append(partial(_as_many, sized.name, sized.shape.index("T"), len(room.targets)))
    for column in kind.columns:
        if scalars.get(column.refers) == tuple[str, ...]:
            asked.append(partial(_within_field, column, column.refers))
        elif column.refers == "states":
            asked.append(partial(_within, column, len(STATES)))
        elif column.refers == "targets" and room.targets:
            asked.append(partial(_within, column, len(room.targets)))
    if len(asked) < 2:
        return asked[0] if asked else None
    return partial(_first, asked)


_UNSIGNED = {size: np.dtype(f"u{size}") for size in (1, 2, 4, 8)}
"""As which indices are read: those below 0 are huge then, so that one comparison finds all that are wrong."""
_CHANNELS = {"color": (3,), "infrared": (1,)}
"""Channels of the pictures of a camera, by its kind; of other kinds they may have any number."""


def _first(asked: Collection[FitCheck], message: Message) -> str:
    for ask in asked:
        if why := ask(message):
            return why
    return ""


def _camera(known: Collection[str], message: Message) -> str:
    name: str = message.camera  # type: ignore[attr-defined]  # such types alone are asked
    if name in known:
        return ""
    if not name:
        return "it names no camera"
    if len(known) == 1:
        return f"it is of camera {name[:80]!r}, not {min(known)!r}"
    return f"the room has no camera {name[:80]!r}"


def _cameras(known: Collection[str], message: Message) -> str:
    names: tuple[str, ...] = message.cameras  # type: ignore[attr-defined]
    strange = next((name for name in names if name not in known), None)
    return "" if strange is None else f"the room has no camera {strange[:80]!r}"


def _pictured(column: str, room: Room, message: Message) -> str:
    camera = room.cameras[message.camera]  # type: ignore[attr-defined]  # known, which was asked first
    width, height = camera.size
    wanted = (height, width, *_CHANNELS.get(camera.kind, ()))
    shape = getattr(message, column).shape
    if shape[: len(wanted)] == wanted[: len(shape)]:
        return ""
    return f"{column} has shape {shape}, {camera.name} gives {wanted}"


def _as_many(column: str, axis: int, count: int, message: Message) -> str:
    found: Array = getattr(message, column)
    size = found.shape[axis]
    return "" if size in (count, 0) else f"{column} is of {size} targets, the room has {count}"


def _within(column: Column, count: int, message: Message) -> str:
    found: Array = getattr(message, column.name)
    if not found.size:
        return ""
    unsigned = found.view(_UNSIGNED[found.itemsize])
    if unsigned.item(unsigned.argmax()) < count:  # max() costs twice as much
        return ""
    return f"{column.name} holds {found.min()} to {found.max()}, where 0 to {count - 1} can be"


def _within_field(column: Column, field: str, message: Message) -> str:
    return _within(column, len(getattr(message, field)), message)
