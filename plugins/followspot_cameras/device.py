"""A camera attached to this machine."""

from __future__ import annotations

import cv2

from followspot import Field, InputDevice, StageParams
from followspot_cameras.live import Capture, LiveCamera


class Device(LiveCamera):
    """Grab from a USB or built-in camera; connects again when it is unplugged and comes back."""

    class Params(StageParams):
        device: InputDevice = Field(
            0, description="number of the camera, or its path, for example /dev/video0"
        )
        fps: float = Field(0.0, ge=0, le=1000, description="frame rate to ask for; 0: its own", unit="1/s")
        fourcc: str = Field("", pattern="^(....)?$", description="pixel format to ask for, for example MJPG")

    params: Params

    @property
    def origin(self) -> str:  # type: ignore[override]  # read-only here
        """The device as the user wrote it."""
        return f"camera {self.params.device}"

    def connect(self) -> Capture:
        """Open the device at the calibrated size."""
        return open_device(self.params.device, self.camera.size, self.params.fps, self.params.fourcc)


def open_device(device: int | str, size: tuple[int, int], fps: float, fourcc: str) -> cv2.VideoCapture:
    """Ask for size (px), rate and format; a driver may give others. One buffer, for the newest picture."""
    capture = cv2.VideoCapture(device, cv2.CAP_ANY if isinstance(device, int) else cv2.CAP_V4L2)
    if fourcc:
        capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*fourcc))
    capture.set(cv2.CAP_PROP_FRAME_WIDTH, size[0])
    capture.set(cv2.CAP_PROP_FRAME_HEIGHT, size[1])
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    if fps:
        capture.set(cv2.CAP_PROP_FPS, fps)
    return capture
