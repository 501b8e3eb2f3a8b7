"""The sensors that the page shows, with the ports that send their readings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from followspot.room import Room, Sensor
from followspot_page.taps.shown_ports import ShownPort


def sensors(room: Room, readings: Iterable[ShownPort]) -> list[dict[str, Any]]:
    """The sensors of the room, then sources that are no sensor of it; readings: ports of sensors."""
    names = dict.fromkeys([*room.sensors, *(port.sensor for port in readings)])
    return [
        _sensor(name, room.sensors.get(name), [port.name for port in readings if port.sensor == name])
        for name in names
    ]


def _sensor(name: str, sensor: Sensor | None, ports: list[str]) -> dict[str, Any]:
    """rate: of the room file, 1/s; mount: what carries it; None if not known."""
    return {
        "name": name,
        "kind": sensor.kind if sensor else "",
        "rate": sensor.rate if sensor else None,
        "mount": str(sensor.mount) if sensor and sensor.mount else None,
        "ports": ports,
    }
