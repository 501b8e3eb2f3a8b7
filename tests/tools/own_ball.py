"""A video of a red ball that flies, and the commands that learn it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from followspot.cli.main import main

ROOT = Path(__file__).parents[2]
GRAPH = str(ROOT / "graphs/single_camera.yaml")
SIZE, RADIUS, FRAMES = (200, 150), 10, 12
RED, BLUE = (30, 20, 200), (200, 60, 20)


def middle(frame: int) -> tuple[int, int]:
    """Where the red ball is, px."""
    return 20 + 14 * frame, 120 - 8 * frame


def picture(frame: int) -> np.ndarray:
    """A red ball that flies, and a blue one that rests, before a pale wall."""
    drawn = np.full((SIZE[1], SIZE[0], 3), (190, 200, 205), np.uint8)
    cv2.circle(drawn, middle(frame), RADIUS, RED, -1, cv2.LINE_AA)
    cv2.circle(drawn, (30, 30), RADIUS, BLUE, -1, cv2.LINE_AA)
    return drawn


def video(folder: Path) -> Path:
    path = folder / "balls.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30, SIZE)
    for frame in range(FRAMES):
        writer.write(picture(frame))
    writer.release()
    return path


def room_for(folder: Path) -> str:
    room = str(folder / "room.yaml")
    assert main(["room", "new", "--video", str(video(folder)), "-o", room]) == 0
    return room


def pick(room: str, *words: str) -> int:
    return main(["calibrate", "targets", "--room", room, *(w for word in words for w in ("--pick", word))])
