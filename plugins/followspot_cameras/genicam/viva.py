"""Backend viva-genicam: GigE Vision and USB3 Vision in one wheel (pip install 'followspot[genicam]')."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import viva_genicam
from viva_genicam import GenApiError, GenicamError, TransportError

from followspot_cameras.camera_features import Feature
from followspot_cameras.frame_numbers import SHORT
from followspot_cameras.genicam.camera import CameraGone, CameraInfo, Picture, refused
from followspot_cameras.genicam.camera_clock import Reading
from followspot_cameras.genicam.clock_features import ClockFeatures, clock_features, frequency, nanoseconds

NAME = "viva-genicam"
UNREACHABLE = "register I/O failed"
"""Begin of errors of a node map that the camera did not answer, or no longer obeys."""
_KINDS = {"StringReg": "String", "IntConverter": "Integer", "Converter": "Float"}
T = TypeVar("T")


def discover(interface: str, timeout: float) -> list[CameraInfo]:
    """Cameras in sight, those on loopback included. interface: own address, "" for all; timeout: s."""
    try:
        network = viva_genicam.discover(round(timeout * 1000), interface or None, all=True)
    except GenicamError:
        network = []
    found = [
        CameraInfo(NAME, i.mac, "GigE Vision", i.ip, i.manufacturer or "", i.model or "", handle=i)
        for i in network
    ]
    try:
        bus = viva_genicam.discover_u3v()
    except GenicamError:
        bus = []
    for i in bus:
        address = f"bus {i.bus} device {i.address}"
        words = (i.manufacturer or "", i.model or "", i.serial or "")
        found.append(CameraInfo(NAME, address, "USB3 Vision", address, *words, handle=i))
    return found


def described(info: CameraInfo) -> CameraInfo:
    """The camera with the serial number and user's name that it gives; unchanged if it does not answer."""
    if info.transport != "GigE Vision":
        return info
    try:
        with viva_genicam.connect_gige(info.handle, monitor=True) as camera:
            serial, name = (_told(camera, feature) for feature in ("DeviceSerialNumber", "DeviceUserID"))
    except GenicamError:
        return info
    return replace(info, serial=serial or info.serial, name=name)


def _told(camera: Any, feature: str) -> str:
    try:
        return str(camera.get(feature)).strip("\0 ")
    except GenicamError:
        return ""


def connect_read_only(info: CameraInfo) -> VivaCamera:
    """The camera, for reading only. Raises CameraGone."""
    if info.transport != "GigE Vision":
        return connect(info, "", 0)
    return VivaCamera(_asked(lambda: viva_genicam.connect_gige(info.handle, monitor=True)), "", 0)


def addressed(address: str) -> CameraInfo | None:
    """None: viva-genicam connects to cameras that it has found."""
    return None


def connect(info: CameraInfo, interface: str, packet_size: int) -> VivaCamera:
    """The camera. Raises CameraGone, also if another program controls it."""
    if info.transport == "GigE Vision":
        camera = _asked(lambda: viva_genicam.connect_gige(info.handle, interface or None))
    else:
        camera = _asked(lambda: viva_genicam.connect_u3v(info.handle))
    return VivaCamera(camera, interface, packet_size)


def _asked(ask: Callable[[], T]) -> T:
    """An answer of the camera. Raises CameraGone, ValueError for what its node map refuses."""
    try:
        return ask()
    except GenApiError as error:
        unreachable = str(error).startswith(UNREACHABLE)
        raise (refused if unreachable else ValueError)(str(error)) from None
    except GenicamError as error:
        raise refused(str(error)) from None


class VivaCamera:
    """A camera that viva-genicam controls."""

    def __init__(self, camera: Any, interface: str, packet_size: int) -> None:
        self._camera = camera
        self._interface, self._packet_size = interface, packet_size
        self._stream: Any = None
        self.largest_identifier = SHORT if camera.transport == "gige" else 0

    @cached_property
    def _names(self) -> frozenset[str]:
        groups = _asked(self._camera.categories)
        return frozenset(name for members in groups.values() for name in members) - frozenset(groups)

    def names(self) -> Collection[str]:
        """Names of the features in the categories of its node map."""
        return self._names

    def feature(self, name: str) -> Feature | None:
        """One of its features."""
        try:
            state = _asked(lambda: self._camera.feature_state(name))
        except ValueError:
            return None
        low, high = (None, None) if state.range is None else (state.range.min, state.range.max)
        kind = _KINDS.get(state.kind, state.kind)
        writable = kind == "Command" or state.access in ("RW", "WO")
        return Feature(name, kind, writable, tuple(state.enum_entries or ()), low, high, state.unit or "")

    def read(self, name: str) -> str:
        """The value of a feature, as text."""
        self._camera.invalidate(name)
        return str(_asked(lambda: self._camera.get(name)))

    def write(self, name: str, text: str) -> None:
        """Set a feature. Raises ValueError if the camera refuses the value."""
        _asked(lambda: self._camera.set(name, text))

    def execute(self, name: str) -> None:
        """Run a command."""
        _asked(lambda: self._camera.execute(name, wait=False))

    @cached_property
    def _clock(self) -> ClockFeatures | None:
        return clock_features(self._names, self.read)

    @cached_property
    def _frequency(self) -> int:
        return frequency(self._names, self.read)

    def read_clock(self) -> Reading | None:
        """A timed reading of its clock; None if it cannot be read."""
        return None if self._clock is None else self._clock.read(self.execute, self.read)

    def start(self) -> None:
        """Begin to send pictures."""
        options = {"iface": self._interface or None, "packet_size": self._packet_size or None}
        self._stream = _asked(lambda: self._camera.stream(deliver_incomplete=True, **options))
        _asked(self._stream.__enter__)

    def next(self, timeout: float) -> Picture | None:
        """The next picture; None if none comes within `timeout`, s."""
        try:
            frame = self._stream.next_frame(round(timeout * 1000))
        except TransportError as error:
            if "timeout" in str(error):
                return None
            raise CameraGone(str(error)) from None
        except GenicamError as error:
            raise CameraGone(str(error)) from None
        if frame is None:
            raise CameraGone("its stream has ended")
        arrival = time.monotonic_ns()
        whole = frame.is_complete
        stamp = None if frame.ts_dev is None else nanoseconds(frame.ts_dev, self._frequency)
        data = np.frombuffer(frame.payload(), "u1") if whole else np.empty(0, "u1")
        missing = 0 if whole else frame.missing_packets or 1
        size = frame.width, frame.height
        padding = frame.padding_x
        return Picture(data, size, frame.pixel_format, frame.block_id, stamp, arrival, missing, padding)

    def overruns(self) -> int:
        """Pictures since the start that waited here and gave way to newer ones."""
        return int(self._stream.stats().frames_backpressure)

    def close(self) -> None:
        """Stop the pictures and release the camera."""
        try:
            if self._stream is not None:
                self._stream.__exit__(None, None, None)
        except GenicamError:
            pass  # it is gone
        finally:
            self._camera.close()
