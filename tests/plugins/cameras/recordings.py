"""Small recordings with pictures that tell their number, and the camera that took them."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from followspot import Camera, Context

SIZE = (64, 48)
STEP = 4
"""Grey levels from one frame to the next; far more than a codec loses."""
FLOOR = 40
RAMP = np.linspace(-32, 32, SIZE[0] * SIZE[1])
GRAIN = np.repeat(np.random.default_rng(0).permutation(RAMP).reshape(SIZE[1], SIZE[0], 1), 3, axis=2)


def context(
    kind: str = "color", size: tuple[int, int] = SIZE, warn: Callable[[str], None] = print
) -> Context:
    eye = np.eye(3)
    camera = Camera("cam3", kind, size, eye, np.zeros(5), eye, np.zeros(3))  # type: ignore[arg-type]
    return Context.serving(camera, name="camera/cam3", warn=warn)


def picture(number: int) -> np.ndarray:
    """Grain around a level that tells the number; the grain gives each frame its share of the file."""
    return (FLOOR + STEP * number + GRAIN).astype("u1")


def record(path: Path, frames: int = 20, codec: str = "MJPG", fps: float = 30.0) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), fps, SIZE)
    for number in range(frames):
        writer.write(picture(number))
    writer.release()
    return path


def numbers(pixels: np.ndarray) -> int:
    """Number of the frame that a picture shows."""
    return round((float(pixels.mean()) - FLOOR) / STEP)
