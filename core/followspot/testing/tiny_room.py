"""The smallest room that every tracking stage works in: two cameras, a floor, one target with a sensor."""

from __future__ import annotations

import numpy as np

from followspot.room import Camera, Member, Room, Sensor, Target


def tiny_room(first: str = "color", second: str = "infrared") -> Room:
    """A colour camera `cam0` and an infrared camera `cam1`, 64 x 48 px, 3 m up; a floor; one red ball.

    The ball carries an inertial sensor `imu0`, 100 readings a second.
    first, second: other kinds of these cameras.
    """
    cameras = {"cam0": _camera("cam0", first, 1.0), "cam1": _camera("cam1", second, -1.0)}
    hue = np.zeros(16)
    hue[0] = 1.0
    area = {"cam0": (2.0, 200.0), "cam1": (2.0, 200.0)}
    red = Target("red", 0.0762, {"cam0": hue}, area, {"cam1": (90.0, 255.0)})
    imu = Sensor("imu0", "imu", rate=100.0, mount=Member("targets", "red"))
    floor = {"floor": np.array([0.0, 0.0, 1.0, 0.0])}
    return Room("tiny", cameras, floor, {"red": red}, sensors={"imu0": imu})


def _camera(name: str, kind: str, side: float) -> Camera:
    """A camera at (0, 2 side, 3) m that looks at the origin."""
    center = np.array([0.0, 2.0 * side, 3.0])
    forward = -center / np.linalg.norm(center)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    matrix = np.array([[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]])
    return Camera(name, kind, (64, 48), matrix, np.zeros(5), rotation, -rotation @ center)
