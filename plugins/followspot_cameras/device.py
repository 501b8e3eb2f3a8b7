"""A camera attached to this machine."""

from __future__ import annotations

import stat
import time
from collections.abc import Iterable
from pathlib import Path

import cv2
from pydantic import field_validator

from followspot import Field, InputDevice, StageParams
from followspot.errors import InputError, Mistake
from followspot.room import Member, Room
from followspot_cameras.live import Capture, CaptureCamera

NUMBERS = range(100)
"""Numbers of cameras; OpenCV gives greater numbers another meaning."""
OLDEST = 1_000_000_000
"""A capture time so long before the picture came, ns, is by another clock than the monotonic one."""


class Device(CaptureCamera):
    """Grab from a USB or built-in camera; connects again when it is unplugged and comes back.

    The capture time is the driver's (V4L2): when the first data of the picture came from the camera.
    """

    class Params(StageParams):
        device: InputDevice = Field(
            0, description="number of the camera, or its path, for example /dev/video0"
        )
        fps: float = Field(0.0, ge=0, le=1000, description="frame rate to ask for; 0: its own", unit="1/s")
        fourcc: str = Field("", pattern="^(....)?$", description="pixel format to ask for, for example MJPG")

        @field_validator("device")
        @classmethod
        def known_device(cls, device: int | str) -> int | str:
            """Accept numbers and paths: OpenCV would open addresses, too."""
            if isinstance(device, int) and device not in NUMBERS:
                raise ValueError(f"a camera has a number from 0 to {NUMBERS[-1]}")
            if isinstance(device, str) and not Path(device).is_absolute():
                raise ValueError(
                    "a camera has a number, or a path such as /dev/video0; cameras.rtsp and "
                    "cameras.stream read addresses, cameras.video reads files"
                )
            return device

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """A path that is there and leads to no device."""
        wrong = not_a_device(params.device)
        return [Mistake(None, f"device: {wrong.text}", wrong.help)] if wrong else []

    @property
    def origin(self) -> str:
        """The device as the user wrote it."""
        return f"camera {self.params.device}"

    def connect(self) -> Capture:
        """Open the device at the calibrated size. Raises InputError for a path that leads to no device."""
        wrong = not_a_device(self.params.device)
        if wrong:
            raise InputError([wrong])
        return open_device(self.params.device, self.camera.size, self.params.fps, self.params.fourcc)

    def captured(self, capture: Capture) -> int:
        """When the driver had the first data of the grabbed picture, ns since 1970."""
        return driver_time(capture.get(cv2.CAP_PROP_POS_MSEC), time.monotonic_ns(), time.time_ns())


def not_a_device(device: int | str) -> Mistake | None:
    """What is wrong with a path that leads to something else than a device; None if it may be plugged in."""
    if isinstance(device, int):
        return None
    try:
        mode = Path(device).stat().st_mode
    except OSError:
        return None
    if stat.S_ISCHR(mode):
        return None
    what = "a folder" if stat.S_ISDIR(mode) else "a pipe" if stat.S_ISFIFO(mode) else "a file"
    remedy = "give the camera's path, such as /dev/video0; cameras.video reads files"
    return Mistake(None, f"{device} is {what}, no camera", remedy)


def driver_time(told: float, steady: int, now: int) -> int:
    """Capture time, ns since 1970, from the driver's; the present if that is by another clock.

    told: by the monotonic clock, ms; steady, now: the present by that clock and since 1970, ns.
    """
    age = steady - round(told * 1e6)
    return now - age if 0 <= age < OLDEST else now


def open_device(device: int | str, size: tuple[int, int], fps: float, fourcc: str) -> cv2.VideoCapture:
    """Ask for size (px), rate and format; a driver may give others. One buffer, for the newest picture."""
    capture = cv2.VideoCapture(device, cv2.CAP_V4L2)
    if fourcc:
        capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*fourcc))
    capture.set(cv2.CAP_PROP_FRAME_WIDTH, size[0])
    capture.set(cv2.CAP_PROP_FRAME_HEIGHT, size[1])
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    if fps:
        capture.set(cv2.CAP_PROP_FPS, fps)
    return capture
