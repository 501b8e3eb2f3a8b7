"""Opens a video file, and reads the properties that its container states."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import cv2

from followspot.errors import InputError, Mistake
from followspot.files import opencv_name, require_regular
from followspot.frame_times import exact_rate
from followspot.room import Camera
from followspot_cameras.picture import check_size
from followspot_cameras.video.container import cut_off


def open_video(path: Path) -> cv2.VideoCapture:
    """A decoder with a second thread that decodes ahead of the graph. Raises InputError."""
    try:
        require_regular(path)
    except OSError as error:
        text = f"{path} cannot be read as a video: {error.strerror}"
        raise InputError([Mistake(None, text, "give the file of a recording")]) from None
    capture = cv2.VideoCapture(opencv_name(path), cv2.CAP_FFMPEG, [cv2.CAP_PROP_N_THREADS, 2])
    if not capture.isOpened():
        raise InputError(
            [
                Mistake(
                    None,
                    f"{path} cannot be read as a video{cut_off(path)}",
                    "give a whole file that ffmpeg can decode, for example .mkv, .mp4 or .avi",
                )
            ]
        )
    return capture


def check_video(path: Path, camera: Camera) -> None:
    """Raise InputError if the file is no video, or does not have the size of the camera's pictures."""
    capture = open_video(path)
    try:
        require_size(capture, camera, path)
    finally:
        capture.release()


def require_size(capture: cv2.VideoCapture, camera: Camera, path: Path) -> None:
    """Raise InputError if an open video does not have the size of the camera's pictures."""
    width, height = (int(capture.get(edge)) for edge in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
    check_size(width, height, camera, str(path))


def announced_frames(path: Path) -> int:
    """Number of frames as the container states it; 0 if its time stamps do not advance."""
    capture = open_video(path)
    try:
        advancing = capture.grab() and capture.grab() and capture.get(cv2.CAP_PROP_PTS) >= 1
        return int(capture.get(cv2.CAP_PROP_FRAME_COUNT)) if advancing else 0
    finally:
        capture.release()


def frame_rate(capture: cv2.VideoCapture, path: Path, given: float) -> Fraction:
    """Frames per second: as given, or as the file states it. Raises InputError if neither does."""
    try:
        return exact_rate(given or capture.get(cv2.CAP_PROP_FPS))
    except (ValueError, OverflowError):
        raise InputError(
            [Mistake(None, f"{path} does not state its frame rate", 'give it: "fps: 30"')]
        ) from None
