"""A V4L2 device that captures: its format, its controls, and its pictures in memory of the driver."""

from __future__ import annotations

import errno
import time
from collections.abc import Iterator
from ctypes import Structure
from fractions import Fraction
from typing import NamedTuple

from followspot.errors import Guess, InputError, Mistake
from followspot.frame_times import SECOND
from followspot.messages import Array
from followspot_cameras.v4l2 import layout
from followspot_cameras.v4l2.kernel import Kernel
from followspot_cameras.v4l2.layout import (
    VIDEO_CAPTURE,
    Buffer,
    BufferRequest,
    BufferType,
    Capability,
    Format,
    FormatDescription,
    StreamParameters,
)
from followspot_cameras.v4l2.pixels import READ

BUFFERS = 4
"""How many pictures the driver is asked to have room for; it may choose another number."""
OLDEST = 1_000_000_000
"""A picture so old, ns, when it comes is stamped by another clock, if its driver does not name the clock."""


class Picture(NamedTuple):
    """One picture as it came.

    data: (B,) uint8, valid until the next picture; sequence: the driver's number of it; captured: ns since
    1970; damaged: the driver found data missing; full: it had no buffer left for the next picture.
    """

    data: Array
    sequence: int
    captured: int
    damaged: bool
    full: bool


class VideoDevice:
    """An open device. Every method raises OSError as the kernel does, also if the camera is gone."""

    def __init__(self, path: str, kernel: Kernel) -> None:
        """Raises OSError, InputError for a device that is no camera."""
        self._kernel, self._path = kernel, path
        self._file = kernel.open(path)
        self._memory: list[Array] = []
        self._taken: Buffer | None = None
        self.fourcc, self.size, self.line = "", (0, 0), 0
        """Pixel format, width and height (px), bytes from one line to the next."""
        try:
            self._require_pictures()
        except BaseException:
            self.close()
            raise

    @property
    def buffers(self) -> int:
        """How many pictures the driver may fill before it gives the next one up."""
        return len(self._memory)

    def ask(self, request: int, argument: Structure) -> None:
        """Carry out a request; the answer is in the argument."""
        self._kernel.ioctl(self._file, request, argument)

    def formats(self) -> Iterator[str]:
        """Pixel formats that the device offers, as four letters."""
        found = FormatDescription(type=VIDEO_CAPTURE)
        while True:
            try:
                self.ask(layout.ENUM_FMT, found)
            except OSError:
                return
            yield _letters(found.pixelformat)
            found = FormatDescription(index=found.index + 1, type=VIDEO_CAPTURE)

    def set_format(self, size: tuple[int, int], fourcc: str) -> None:
        """Ask for width and height (px) and a pixel format, "" for one that costs little; a driver may give
        another size. Raises InputError for a format that the device does not offer, or that is not read.
        """
        offered = list(self.formats())
        readable = [known for known in READ if known in offered]
        wanted = fourcc or (self._current() if self._current() in readable else next(iter(readable), ""))
        if wanted not in readable:
            what = f'cannot send "{fourcc}"' if fourcc else f"sends {', '.join(offered) or 'nothing'}"
            raise InputError([Mistake(None, f"{self._path} {what}", Guess(fourcc, "fourcc", readable))])
        form = Format(type=VIDEO_CAPTURE)
        form.fmt.pix.width, form.fmt.pix.height = size
        form.fmt.pix.pixelformat = int.from_bytes(wanted.encode("latin-1"), "little")
        self.ask(layout.S_FMT, form)
        pix = form.fmt.pix
        self.fourcc, self.size, self.line = (
            _letters(pix.pixelformat),
            (pix.width, pix.height),
            pix.bytesperline,
        )

    def set_rate(self, rate: float) -> None:
        """Ask for a frame rate, 1/s; a driver may give another, and one without rates is left as it is."""
        period = 1 / Fraction(rate).limit_denominator(1001)
        parameters = StreamParameters(type=VIDEO_CAPTURE)
        try:
            self.ask(layout.G_PARM, parameters)
        except OSError:
            return
        if parameters.capability & layout.HAS_RATE:
            parameters.numerator, parameters.denominator = period.numerator, period.denominator
            self.ask(layout.S_PARM, parameters)

    def start(self) -> None:
        """Give the driver its buffers, and begin the pictures."""
        request = BufferRequest(count=BUFFERS, type=VIDEO_CAPTURE, memory=layout.MAPPED)
        self.ask(layout.REQBUFS, request)
        for index in range(request.count):
            buffer = self._buffer(index)
            self.ask(layout.QUERYBUF, buffer)
            self._memory.append(self._kernel.map(self._file, buffer.length, buffer.m.offset))
            self.ask(layout.QBUF, buffer)
        self.ask(layout.STREAMON, BufferType(VIDEO_CAPTURE))

    def next(self, timeout: float) -> Picture | None:
        """The next picture; None if none comes within `timeout`, s."""
        if self._taken is not None:
            self.ask(layout.QBUF, self._taken)
            self._taken = None
        if not self._kernel.wait(self._file, timeout):
            return None
        buffer = self._buffer(0)
        try:
            self.ask(layout.DQBUF, buffer)
        except OSError as error:
            if error.errno == errno.EAGAIN:
                return None
            raise
        self._taken = buffer
        damaged = bool(buffer.flags & layout.DAMAGED)
        data = self._memory[buffer.index][: buffer.bytesused]
        return Picture(data, buffer.sequence, capture_time(buffer), damaged, self._is_full(buffer.index))

    def close(self) -> None:
        """End the pictures, and release the device."""
        self._kernel.close(self._file)

    def _require_pictures(self) -> None:
        able = Capability()
        try:
            self.ask(layout.QUERYCAP, able)
        except OSError as error:
            if error.errno != errno.ENOTTY:
                raise
        flags = able.device_caps if able.capabilities & layout.HAS_DEVICE_CAPS else able.capabilities
        if flags & layout.HAS_CAPTURE and flags & layout.HAS_STREAMING:
            return
        remedy = "a camera may have several: try the next number, or see `v4l2-ctl --list-devices`"
        raise InputError([Mistake(None, f"{self._path} sends no pictures", remedy)])

    def _current(self) -> str:
        form = Format(type=VIDEO_CAPTURE)
        self.ask(layout.G_FMT, form)
        return _letters(form.fmt.pix.pixelformat)

    def _is_full(self, taken: int) -> bool:
        """Whether all other buffers have pictures already, so that the driver must give up the next one."""
        for index in range(len(self._memory)):
            buffer = self._buffer(index)
            if index != taken:
                self.ask(layout.QUERYBUF, buffer)
                if not buffer.flags & layout.DONE:
                    return False
        return True

    def _buffer(self, index: int) -> Buffer:
        return Buffer(index=index, type=VIDEO_CAPTURE, memory=layout.MAPPED)


def capture_time(buffer: Buffer) -> int:
    """When the driver had the picture's first or last data, ns since 1970; the present if it does not say."""
    told = buffer.timestamp.seconds * SECOND + buffer.timestamp.microseconds * 1000
    steady, now = time.monotonic_ns(), time.time_ns()
    clock = buffer.flags & layout.CLOCK
    if clock not in (layout.UNKNOWN, layout.MONOTONIC):
        return now
    return driver_time(told, steady, now, OLDEST if clock == layout.UNKNOWN else steady)


def driver_time(told: int, steady: int, now: int, oldest: int) -> int:
    """Capture time, ns since 1970, from the driver's; the present if that is by another clock.

    told: by the monotonic clock, ns; steady, now: the present by that clock and since 1970, ns; oldest: a
    picture of this age, ns, is not believed.
    """
    age = steady - told
    return now - age if 0 <= age < oldest else now


def _letters(code: int) -> str:
    return code.to_bytes(4, "little").decode("latin-1")
