"""A camera that is written in the formats of other programs, and read again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from followspot.room import Camera
from followspot_room.calibration import read_calibration
from followspot_room.exporting import WRITABLE, write_calibration


def back(folder: Path, key: str, written: list[Camera]) -> tuple[Camera, ...]:
    suffix = {"qualisys": "x.qca.txt", "opencv": "x.yml", "svoboda": "x"}.get(key, "x.toml")
    write_calibration(written, folder / suffix, WRITABLE[key])
    return read_calibration(folder / suffix).cameras


def a_camera(**changes: Any) -> Camera:
    fields: dict[str, Any] = {
        "name": "left",
        "kind": "color",
        "size": (640, 480),
        "matrix": np.array([[500.0, 0, 320], [0, 510, 240], [0, 0, 1]]),
        "distortion": np.array([-0.2, 0.05, 0.003, -0.002, 0.0]),
        "rotation": cv2.Rodrigues(np.array([0.3, -1.2, 0.4]))[0],
        "translation": np.array([0.1, 0.2, 3.0]),
    }
    return Camera(**fields | changes)
