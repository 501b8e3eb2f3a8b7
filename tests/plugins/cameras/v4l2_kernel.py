"""A kernel with one V4L2 camera: the requests of V4L2, answered as its documentation says."""

from __future__ import annotations

import ctypes
import errno
import os
import time
from collections import deque
from collections.abc import Sequence

import numpy as np

from followspot_cameras.v4l2 import layout

BUFFERS = 4
AGE = 25_000_000
"""Between the first data of a picture and the end of the wait for it, ns."""
CONTROLS = (
    (0x009A0901, 3, b"Auto Exposure", 0, 3, 0, {1: b"Manual Mode", 3: b"Aperture Priority Mode"}),
    (0x009A0902, 1, b"Exposure Time, Absolute", 3, 2047, 0, {}),
    (0x00980918, 9, b"Power Line Frequency", 0, 1, 0, {0: 50, 1: 60}),
    (0x0098090C, 2, b"White Balance, Automatic", 0, 1, 0, {}),
    (0x00980913, 1, b"Gain", 0, 100, layout.READ_ONLY, {}),
    (0x009A0001, 6, b"Camera Controls", 0, 0, 0, {}),
    (0x00980911, 1, b"Old", 0, 1, layout.DISABLED, {}),
)


class Camera:
    """steps: what happens while the program waits, in order: a number of pictures that come, of which the
    driver gives up those without a buffer; a negative number of pictures that it leaves out; "damaged", a
    picture that lacks data; bytes, a picture of these; "gone", the camera is unplugged, as it is after the
    last step; "still", nothing comes.
    """

    def __init__(
        self,
        steps: Sequence[int | str | bytes],
        formats: Sequence[str] = ("YUYV",),
        size: tuple[int, int] = (64, 48),
        *,
        data: bytes = b"",
        line: int = 0,
        clock: int = layout.MONOTONIC,
        counts: bool = True,
        capabilities: int = layout.HAS_CAPTURE | layout.HAS_STREAMING,
    ) -> None:
        self.steps = deque(steps)
        self.formats, self.size, self.data, self.line = formats, size, data, line
        self.clock, self.counts, self.capabilities = clock, counts, capabilities
        self.fourcc = formats[0] if formats else "    "
        self.set: list[tuple[int, int]] = []
        self.rate = (0, 0)
        self.opened: list[str] = []
        self.closed = 0
        self.gone = False

    def open(self, path: str) -> int:
        self.opened.append(path)
        self.memory: list[np.ndarray] = []
        self.queue: deque[int] = deque()
        self.done: deque[tuple[int, int, int, int]] = deque()
        self.sequence, self.streams, self.gone = 0, False, False
        if not self.steps:
            raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
        return 7

    def close(self, file: int) -> None:
        self.closed += 1

    def map(self, file: int, length: int, offset: int) -> np.ndarray:
        self.memory.append(np.zeros(length, "u1"))
        return self.memory[offset // 4096]

    def wait(self, file: int, timeout: float) -> bool:
        assert self.streams
        if not self.done:
            step = self.steps.popleft() if self.steps else "gone"
            if isinstance(step, int) and step < 0:
                self.sequence -= step
                step = 1
            if step == "gone":
                self.gone = True
            elif step == "damaged":
                self._picture(self.data[:10], layout.DAMAGED)
            elif isinstance(step, bytes):
                self._picture(step)
            elif isinstance(step, int):
                for _ in range(step):
                    self._picture(self.data)
        return bool(self.done) or self.gone

    def _picture(self, data: bytes, flags: int = 0) -> None:
        if self.queue:
            index = self.queue.popleft()
            self.memory[index][: len(data)] = np.frombuffer(data, "u1")
            self.done.append((index, len(data), flags, self.sequence if self.counts else 0))
        self.sequence += 1

    def ioctl(self, file: int, request: int, argument: ctypes.Structure) -> None:
        if self.gone:
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
        answers = {
            layout.QUERYCAP: self._able,
            layout.ENUM_FMT: self._offered,
            layout.G_FMT: self._current,
            layout.S_FMT: self._chosen,
            layout.G_PARM: lambda a: setattr(a, "capability", layout.HAS_RATE),
            layout.S_PARM: lambda a: setattr(self, "rate", (a.numerator, a.denominator)),
            layout.REQBUFS: lambda a: setattr(a, "count", BUFFERS),
            layout.QUERYBUF: self._buffer,
            layout.QBUF: lambda a: self.queue.append(a.index),
            layout.DQBUF: self._taken,
            layout.STREAMON: lambda a: setattr(self, "streams", True),
            layout.QUERYCTRL: self._control,
            layout.QUERYMENU: self._entry,
            layout.S_CTRL: lambda a: self.set.append((a.id, a.value)),
        }
        answers[request](argument)

    def _able(self, able: layout.Capability) -> None:
        able.capabilities = 0x85A0_0001  # of all devices of the camera together
        able.device_caps = self.capabilities

    def _offered(self, found: layout.FormatDescription) -> None:
        found.pixelformat = code(self._member(self.formats, found.index))

    def _current(self, form: layout.Format) -> None:
        form.fmt.pix.pixelformat = code(self.fourcc)

    def _chosen(self, form: layout.Format) -> None:
        self.fourcc = form.fmt.pix.pixelformat.to_bytes(4, "little").decode()
        form.fmt.pix.width, form.fmt.pix.height = self.size
        form.fmt.pix.bytesperline = self.line

    def _buffer(self, buffer: layout.Buffer) -> None:
        buffer.length, buffer.m.offset = 65536, 4096 * buffer.index
        done = any(index == buffer.index for index, *_ in self.done)
        buffer.flags = layout.DONE if done else layout.QUEUED

    def _taken(self, buffer: layout.Buffer) -> None:
        if not self.done:
            raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        buffer.index, buffer.bytesused, flags, buffer.sequence = self.done.popleft()
        buffer.flags = flags | self.clock
        stamp = (time.monotonic_ns() - AGE) // 1000
        buffer.timestamp.seconds, buffer.timestamp.microseconds = divmod(stamp, 1_000_000)

    def _control(self, found: layout.ControlQuery) -> None:
        after = found.id & ~layout.NEXT_CONTROL
        known = sorted(one for one in CONTROLS if one[0] > after)
        one = self._member(known, 0)
        found.id, found.type, found.name, found.minimum, found.maximum, found.flags = one[:6]

    def _entry(self, menu: layout.MenuQuery) -> None:
        entries = next(one[6] for one in CONTROLS if one[0] == menu.id)
        entry = self._member(entries, menu.index) if menu.index in entries else self._member((), 0)
        setattr(menu.entry, "name" if isinstance(entry, bytes) else "value", entry)

    def _member(self, members, index):
        try:
            return members[index]
        except IndexError:
            raise OSError(errno.EINVAL, os.strerror(errno.EINVAL)) from None


def code(fourcc: str) -> int:
    return int.from_bytes(fourcc.encode(), "little")
