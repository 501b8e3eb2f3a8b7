"""Controls of a V4L2 device by their names, for example `exposure_time_absolute: 100`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from ctypes import Structure
from dataclasses import dataclass

from followspot_cameras.camera_features import Feature, Value, set_features
from followspot_cameras.v4l2 import layout
from followspot_cameras.v4l2.layout import Control, ControlQuery, MenuQuery

Ask = Callable[[int, Structure], None]
"""Carries out a request; the answer is in the argument. Raises OSError."""
_MENU, _INTEGER_MENU = 3, 9
_KINDS = {
    1: "Integer",
    2: "Boolean",
    _MENU: "Enumeration",
    4: "Command",
    8: "Integer",
    _INTEGER_MENU: "Enumeration",
}


@dataclass(frozen=True)
class KnownControl:
    """A control: its number in the driver, what it is, and the number of each entry of its menu."""

    id: int
    feature: Feature
    entries: Mapping[str, int]

    def value(self, given: Value) -> int:
        """The number that the driver takes for a value that was checked."""
        return self.entries[str(given)] if self.entries else int(given)


def set_controls(ask: Ask, wanted: Mapping[str, Value], origin: str) -> None:
    """Set controls, in the order in which they stand.

    Raises InputError, with all mistakes, for those that the device does not have or take; OSError.
    """
    if not wanted:
        return
    known = {control.feature.name: control for control in controls(ask)}

    def write(name: str, value: Value) -> None:
        ask(layout.S_CTRL, Control(known[name].id, known[name].value(value)))

    set_features(wanted, known, lambda name: known[name].feature, write, origin, "control")


def controls(ask: Ask) -> Iterator[KnownControl]:
    """All controls of the device that have a number as value."""
    found = ControlQuery(id=layout.NEXT_CONTROL)
    while _answers(ask, layout.QUERYCTRL, found):
        if found.type in _KINDS and not found.flags & layout.DISABLED:
            entries = _entries(ask, found) if found.type in (_MENU, _INTEGER_MENU) else {}
            yield KnownControl(found.id, _feature(found, entries), entries)
        found = ControlQuery(id=found.id | layout.NEXT_CONTROL)


def _feature(found: ControlQuery, entries: Mapping[str, int]) -> Feature:
    name = re.sub(r"[^a-z0-9]+", "_", found.name.decode("latin-1").lower()).strip("_")
    writable = not found.flags & layout.READ_ONLY
    return Feature(name, _KINDS[found.type], writable, tuple(entries), found.minimum, found.maximum)


def _entries(ask: Ask, found: ControlQuery) -> dict[str, int]:
    """Names of a menu -> their numbers; a driver may leave numbers out."""
    entries: dict[str, int] = {}
    for index in range(found.minimum, found.maximum + 1):
        menu = MenuQuery(id=found.id, index=index)
        if _answers(ask, layout.QUERYMENU, menu):
            named = found.type == _MENU
            entries[menu.entry.name.decode("latin-1") if named else str(menu.entry.value)] = index
    return entries


def _answers(ask: Ask, request: int, argument: Structure) -> bool:
    """Whether the device supports the request."""
    try:
        ask(request, argument)
    except OSError:
        return False
    return True
