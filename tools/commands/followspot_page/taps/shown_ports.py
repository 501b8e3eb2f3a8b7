"""The page's taps: one at each port that it can show, on this host and on others."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path

from followspot.graph.output_ports import output_ports
from followspot.graph.plan import Plan, PlannedStage
from followspot.inertial import Inertial
from followspot.library.handle import Tapping
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot_dashboard.gate import SOCKET
from followspot_dashboard.picture import FARTHEST, PICTURES, Picture
from followspot_page.display.message_views import SHOWN, SMOOTH
from followspot_page.display.scene import bounds, farthest
from followspot_page.taps.replaced_tracks import followed

TAP = "dashboard.tap"
_PIXELS, _MOST = 320 * 240, 1280
"""Pixels of a preview, and the largest number of columns."""
SMOOTH_RATE = 30.0
"""Messages per second of tracks, poses and inertial readings; they are small, and smooth motion is easier to
follow."""
SENSOR_RATE = 5.0
"""Messages per second of other sensors, beside those at the times of pictures."""

PLOT_RATE = 10.0
"""Messages per second of ports of which only figures are plotted."""


@dataclass(frozen=True)
class ShownPort:
    """A port that the page shows.

    name: STAGE.PORT; host: of its stage, "" for here; source: True for a source; size: of its pictures, px;
    farthest: depth that has the last colour, m; sensor: whose readings it sends, "" if of none; plotted:
    whether only its figures are shown.
    """

    name: str
    type: type[Message]
    host: str
    source: bool
    size: tuple[int, int] = (320, 240)
    farthest: float = FARTHEST
    sensor: str = ""
    plotted: bool = False

    @property
    def is_picture(self) -> bool:
        """Whether it is shown as pictures."""
        return issubclass(self.type, PICTURES)

    @property
    def watched_only(self) -> bool:
        """Whether nothing of it is sent while no browser shows the page."""
        return self.is_picture or self.sensor != ""

    @property
    def rate(self) -> float:
        """Messages per second that are shown beside those at the times of pictures."""
        if issubclass(self.type, SMOOTH):
            return SMOOTH_RATE
        if self.plotted:
            return PLOT_RATE
        return SENSOR_RATE if self.sensor else 0.0


def shown_ports(plan: Plan) -> tuple[ShownPort, ...]:
    """The ports of a graph that the page can show: the last tracks alone of those that follow each other."""
    found = []
    low, high = bounds(plan.room)
    superseded = followed(plan)
    for stage in plan.stages:
        its = ports(load_stage(stage.uses))
        camera = plan.room.cameras[stage.camera] if stage.camera else None
        size = camera.size if camera else (320, 240)
        depth = farthest(camera, low, high) if camera else FARTHEST
        for port in its.outputs:
            name, host = f"{stage.name}.{port.name}", plan.host_of(stage.worker)
            if issubclass(port.type, SHOWN) and name not in superseded:
                found.append(ShownPort(name, port.type, host, its.source, size, depth))
            elif not issubclass(port.type, SHOWN) and (sensor := _sensor(stage, port.type)):
                found.append(ShownPort(name, port.type, host, its.source, sensor=sensor))
    return tuple(found)


def plotted_ports(plan: Plan, names: Collection[str]) -> tuple[ShownPort, ...]:
    """The ports among these that are not shown anyway."""
    shown = {port.name for port in shown_ports(plan)}
    return tuple(
        ShownPort(name, kind, plan.host_of_stage(name.rpartition(".")[0]), source=False, plotted=True)
        for name, kind in output_ports(plan).items()
        if name in names and name not in shown
    )


def sent_kinds(shown: Iterable[ShownPort]) -> dict[str, type[Message]]:
    """The type of the messages that the tap of each port sends."""
    return {port.name: Picture if port.is_picture else port.type for port in shown}


def longest_side(size: tuple[int, int]) -> int:
    """Longest side of a picture's preview, px, for a fixed number of pixels. size: width and height, px."""
    width, height = size
    shape = max(width, height) / min(width, height)
    return min(_MOST, round(math.sqrt(_PIXELS * shape)))


def tappings(looked_at: Iterable[ShownPort], folder: Path, rate: float) -> list[Tapping]:
    """A tap for each port. folder: of the page, for taps of this host; rate: pictures per second."""
    found = []
    for port in looked_at:
        look = {"picture_rate": rate, "message_rate": port.rate, "maximum_side": longest_side(port.size)}
        place = {} if port.host else {"folder": str(folder), "socket": str(folder / SOCKET)}
        look["sets_times"] = port.source and not port.host and not port.sensor  # sensors run ahead of cameras
        look |= {"farthest": port.farthest, "watched_only": port.watched_only}
        found.append(Tapping(port.name, TAP, {**place, "port": port.name, **look}))
    return found


def _sensor(stage: PlannedStage, sent: type[Message]) -> str:
    """The sensor whose readings a stage sends: the one that it serves, or its own; "" if none."""
    if stage.member is not None and stage.member.set == "sensors":
        return stage.member.name
    return stage.name if issubclass(sent, Inertial) else ""
