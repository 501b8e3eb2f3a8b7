"""A camera attached to this machine."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import ClassVar

from pydantic import field_validator

from followspot import Field, InputDevice, Source, StageParams, at
from followspot.errors import InputError, Mistake
from followspot.room import Member, Room
from followspot.tracking import Frame
from followspot_cameras.frame_numbers import FrameNumbers
from followspot_cameras.picture import check_size
from followspot_cameras.reconnection import READ_TIMEOUT, LiveCamera
from followspot_cameras.v4l2.controls import set_controls
from followspot_cameras.v4l2.kernel import Kernel, Linux
from followspot_cameras.v4l2.pixels import Damaged, frame_of
from followspot_cameras.v4l2.video_device import Picture, VideoDevice

NUMBERS = range(100)
"""Numbers of cameras."""
LONGEST_LOOK = 0.2
"""Longest wait for a picture before the stage looks whether the run ends, s."""


class Device(LiveCamera):
    """Pictures of a USB or built-in camera (V4L2), each with the driver's capture time and number.

    Pictures that are damaged, or that the driver's numbers skip, stand in the ledger as lost at the source.
    The stage connects again to a camera that was unplugged and comes back.
    """

    class Params(StageParams):
        device: InputDevice = Field(
            0, description="number of the camera, or its path, for example /dev/video0"
        )
        fps: float = Field(0.0, ge=0, le=1000, description="frame rate to ask for; 0: its own", unit="1/s")
        fourcc: str = Field("", pattern="^(....)?$", description="pixel format to ask for, for example MJPG")
        controls: dict[str, bool | int | str] = Field(
            {},
            description="controls of the camera and their values, in the order in which they are set, for "
            "example {auto_exposure: Manual Mode, exposure_time_absolute: 100}",
        )
        read_timeout: float = Field(
            5.0,
            gt=0,
            le=3600,
            unit="s",
            description=READ_TIMEOUT,
        )

        @field_validator("device")
        @classmethod
        def known_device(cls, device: int | str) -> int | str:
            """Accept numbers and paths."""
            if isinstance(device, int) and device not in NUMBERS:
                raise ValueError(f"a camera has a number from 0 to {NUMBERS[-1]}")
            if isinstance(device, str) and not Path(device).is_absolute():
                raise ValueError(
                    "a camera has a number, or a path such as /dev/video0; cameras.rtsp and "
                    "cameras.stream read addresses, cameras.video reads files"
                )
            return device

    params: Params
    kernel: ClassVar[Kernel] = Linux()

    @classmethod
    def nominal_rate(cls, params: Params) -> float | None:
        """The frame rate that the device is asked for, Hz; None for its own."""
        return params.fps or None

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """A path that leads to no device. Warn if nothing is there: it may be plugged in later."""
        wrong = not_a_device(params.device)
        if wrong:
            return [Mistake(None, f"device: {wrong.text}", wrong.help)]
        path = Path(path_of(params.device))
        camera = room.cameras.get(member.name) if member is not None else None
        if (camera is not None and camera.host) or path.exists():
            return []
        there = ", ".join(map(str, sorted(path.parent.glob("video*")))) or "none"
        text = f"device: {path} is not there; the run waits for it"
        return [Mistake(None, text, f"plug the camera in; cameras here: {there}", warning=True)]

    @property
    def origin(self) -> str:
        """The device as the user wrote it."""
        return f"camera {self.params.device}"

    def process(self) -> Source[Frame]:
        """Pictures as they come. Raises InputError for a path, format or control that is not the camera's."""
        self._numbers = FrameNumbers(0)
        yield from super().process()

    def session(self) -> Iterator[Frame]:
        """Pictures of one connection. Raises ConnectionError if the camera is gone; InputError."""
        wrong = not_a_device(self.params.device)
        if wrong:
            raise InputError([wrong])
        try:
            with closing(VideoDevice(path_of(self.params.device), self.kernel)) as device:
                self._prepare(device)
                yield from self._frames(device)
        except OSError as error:
            if isinstance(error, ConnectionError):
                raise
            raise ConnectionError(os.strerror(error.errno) if error.errno else str(error)) from None

    def _prepare(self, device: VideoDevice) -> None:
        """Set format, rate and controls. Raises OSError, InputError."""
        device.set_format(self.camera.size, self.params.fourcc)
        check_size(*device.size, self.camera, self.origin)
        if self.params.fps:
            device.set_rate(self.params.fps)
        set_controls(device.ask, self.params.controls, self.origin)

    def _frames(self, device: VideoDevice) -> Iterator[Frame]:
        """Frames until the camera is gone, or the run ends."""
        self._numbers.connected_again(0)
        self._full_until = -1
        device.start()
        heard = time.monotonic()
        while not self.stopped.is_set():
            picture = device.next(min(LONGEST_LOOK, self.params.read_timeout))
            if picture is None:
                if time.monotonic() - heard > self.params.read_timeout:
                    raise ConnectionError(f"no picture came for {self.params.read_timeout:g} s")
                continue
            heard = time.monotonic()
            frame = self._frame(picture, device)
            if frame is not None:
                yield at(picture.captured, frame, seq=self._numbers.number)

    def _frame(self, picture: Picture, device: VideoDevice) -> Frame | None:
        """The picture as a frame; None if it is damaged. What is lost goes to the ledger."""
        self._count(picture, device.buffers)
        if not picture.damaged:
            try:
                loan = self.context.loan
                return frame_of(picture.data, device.fourcc, device.line, self.camera, loan, self.origin)
            except Damaged:
                pass
        self.context.lost("packet_loss", 1)
        return None

    def _count(self, picture: Picture, buffers: int) -> None:
        """Number the picture; frames that are missing before it go to the ledger."""
        numbers = self._numbers
        missing = numbers.next(picture.sequence)
        if missing is None:  # a driver that does not count
            numbers.connected_again(0)
            missing = numbers.next(picture.sequence) or 0
        full = numbers.number - missing <= self._full_until
        self.context.lost("device_overrun" if full else "gap", missing)
        if picture.full:  # the pictures in all other buffers come before one that was given up
            self._full_until = numbers.number + buffers


def path_of(device: int | str) -> str:
    """The path of a device that a user gave by number or path."""
    return f"/dev/video{device}" if isinstance(device, int) else device


def not_a_device(device: int | str) -> Mistake | None:
    """The mistake if the path is not a device; None if it is one, or one may be plugged in there."""
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
