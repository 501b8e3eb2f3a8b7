"""The page's taps: one at each port that it can show, on this host and on others."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from followspot.graph.plan import Plan
from followspot.library.handle import Tapping
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.ports import ports
from followspot.tracking import Frame
from followspot_dashboard.gate import SOCKET
from followspot_dashboard.picture import Picture
from followspot_page.views import SHOWN, SMOOTH

TAP = "dashboard.tap"
_PIXELS, _MOST = 320 * 240, 1280
"""Pixels of a preview, and the largest number of columns."""
SMOOTH_RATE = 30.0
"""Messages per second of tracks and poses; they are small, and smooth motion is easier to follow."""


@dataclass(frozen=True)
class ShownPort:
    """A port that the page shows.

    name: STAGE.PORT; host: of its stage, "" for here; source: True for a source; size: of its pictures, px.
    """

    name: str
    type: type[Message]
    host: str
    source: bool
    size: tuple[int, int] = (320, 240)


def shown_ports(plan: Plan) -> tuple[ShownPort, ...]:
    """The ports of a graph that the page can show."""
    found = []
    for stage in plan.stages:
        its = ports(load_stage(stage.uses))
        size = plan.room.cameras[stage.camera].size if stage.camera else (320, 240)
        for port in its.outputs:
            if port.type in SHOWN:
                name = f"{stage.name}.{port.name}"
                found.append(ShownPort(name, port.type, plan.host_of(stage.worker), its.source, size))
    return tuple(found)


def sent_kinds(shown: Iterable[ShownPort]) -> dict[str, type[Message]]:
    """The type of the messages that the tap of each port sends."""
    return {port.name: Picture if port.type is Frame else port.type for port in shown}


def longest_side(size: tuple[int, int]) -> int:
    """Longest side of a picture's preview, px, for a fixed number of pixels. size: width and height, px."""
    width, height = size
    shape = max(width, height) / min(width, height)
    return min(_MOST, round(math.sqrt(_PIXELS * shape)))


def tappings(looked_at: Iterable[ShownPort], folder: Path, rate: float) -> list[Tapping]:
    """A tap for each port. folder: of the page, for taps of this host; rate: pictures per second."""
    found = []
    for port in looked_at:
        smooth = SMOOTH_RATE if port.type in SMOOTH else 0.0
        look = {"picture_rate": rate, "message_rate": smooth, "maximum_side": longest_side(port.size)}
        place = {} if port.host else {"folder": str(folder), "socket": str(folder / SOCKET)}
        look["sets_times"] = port.source and not port.host
        found.append(Tapping(port.name, TAP, {**place, "port": port.name, **look}))
    return found
