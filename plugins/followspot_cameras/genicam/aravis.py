"""Backend Aravis, through GObject introspection: packages of the distribution, such as gir1.2-aravis-0.8."""

from __future__ import annotations

import ipaddress
import time
from collections.abc import Callable, Collection
from functools import cached_property
from threading import Lock
from typing import Any, TypeVar

import gi
import numpy as np

gi.require_version("Aravis", "0.8")
from gi.repository import Aravis, GLib  # noqa: E402  # the version is chosen before

from followspot.messages import Array  # noqa: E402
from followspot_cameras.camera_features import Feature  # noqa: E402
from followspot_cameras.frame_numbers import SHORT  # noqa: E402
from followspot_cameras.genicam.camera import CameraInfo, Picture, refused  # noqa: E402
from followspot_cameras.genicam.camera_clock import Reading  # noqa: E402
from followspot_cameras.genicam.clock_features import clock_features  # noqa: E402
from followspot_cameras.genicam.pixel_codes import format_name  # noqa: E402

NAME = "aravis"
BUFFERS = 16
"""Pictures that Aravis fills before it gives the next one up."""
_KINDS = (
    (Aravis.GcEnumeration, "Enumeration"),
    (Aravis.GcBoolean, "Boolean"),
    (Aravis.GcCommand, "Command"),
    (Aravis.GcInteger, "Integer"),
    (Aravis.GcFloat, "Float"),
    (Aravis.GcString, "String"),
)
"""An enumeration is an integer, too."""
T = TypeVar("T")
_list = Lock()
"""Held while Aravis' list of cameras is read: a search by the source of another camera frees its texts."""


def discover(interface: str, timeout: float) -> list[CameraInfo]:
    """Cameras in sight. Aravis asks at all interfaces and waits as long as it sees fit."""
    with _list:
        Aravis.update_device_list()
        return [_info(index) for index in range(Aravis.get_n_devices())]


def _info(index: int) -> CameraInfo:
    return CameraInfo(
        NAME,
        Aravis.get_device_id(index),
        {"GigEVision": "GigE Vision", "USB3Vision": "USB3 Vision"}.get(
            Aravis.get_device_protocol(index), Aravis.get_device_protocol(index)
        ),
        Aravis.get_device_address(index) or "",
        Aravis.get_device_vendor(index) or "",
        Aravis.get_device_model(index) or "",
        Aravis.get_device_serial_nbr(index) or "",
    )


def described(info: CameraInfo) -> CameraInfo:
    """The camera as it is: Aravis tells everything at once."""
    return info


def connect_read_only(info: CameraInfo) -> AravisCamera:
    """The camera; that of another program cannot be read. Raises CameraGone."""
    return connect(info, "", 0)


def addressed(address: str) -> CameraInfo | None:
    """The camera at an address in the network, found or not."""
    try:
        ipaddress.ip_address(address)
    except ValueError:
        return None
    return CameraInfo(NAME, address, "GigE Vision", address)


def connect(info: CameraInfo, interface: str, packet_size: int) -> AravisCamera:
    """The camera. Raises CameraGone, also if another program controls it."""
    return AravisCamera(_asked(lambda: Aravis.Camera.new(info.identity)), packet_size)


def _asked(ask: Callable[[], T]) -> T:
    """An answer of the camera. Raises CameraGone, ValueError for a value that the camera refuses."""
    try:
        return ask()
    except GLib.Error as error:
        of_node_map = error.domain == "arv-gc-error-quark"
        raise (ValueError if of_node_map else refused)(error.message) from None


class AravisCamera:
    """A camera that Aravis holds."""

    def __init__(self, camera: Any, packet_size: int) -> None:
        self._camera, self._device = camera, camera.get_device()
        self._genicam = self._device.get_genicam()
        self._stream: Any = None
        self._buffer: Any = None
        self._memory: dict[Any, Array] = {}
        """Buffer -> its memory, (B,) uint8, which Aravis fills."""
        if packet_size and camera.is_gv_device():
            _asked(lambda: camera.gv_set_packet_size(packet_size))
        self.largest_identifier = SHORT if camera.is_gv_device() else 0

    @cached_property
    def _names(self) -> frozenset[str]:
        found: set[str] = set()
        open_categories = ["Root"]
        while open_categories:
            node = self._genicam.get_node(open_categories.pop())
            if isinstance(node, Aravis.GcCategory):
                members = set(node.get_features()) - found
                found |= members
                open_categories += members
        return frozenset(n for n in found if not isinstance(self._genicam.get_node(n), Aravis.GcCategory))

    def names(self) -> Collection[str]:
        """Names of all features in the categories of the node map."""
        return self._names

    def feature(self, name: str) -> Feature | None:
        """One of its features."""
        node = self._device.get_feature(name)
        if node is None:
            return None
        kind = next((kind for form, kind in _KINDS if isinstance(node, form)), type(node).__name__)
        low, high = self._limits(name, kind)
        entries = ()
        if kind == "Enumeration":
            entries = tuple(
                _asked(lambda: self._device.dup_available_enumeration_feature_values_as_strings(name))
            )
        writable = kind == "Command" or node.get_actual_access_mode() != Aravis.GcAccessMode.RO
        unit = node.get_unit() if kind in ("Integer", "Float") else None
        return Feature(name, kind, writable, entries, low, high, unit or "")

    def _limits(self, name: str, kind: str) -> tuple[float | None, float | None]:
        bounds = {
            "Integer": self._device.get_integer_feature_bounds,
            "Float": self._device.get_float_feature_bounds,
        }
        if kind not in bounds:
            return None, None
        try:
            low, high = _asked(lambda: bounds[kind](name))
        except ValueError:  # they stand in nodes that the node map lacks
            return None, None
        return float(low), float(high)

    def read(self, name: str) -> str:
        """The value of a feature, as text."""
        return str(_asked(lambda: self._device.get_feature(name).get_value_as_string()))

    def write(self, name: str, text: str) -> None:
        """Set a feature. Raises ValueError if the camera refuses the value."""
        _asked(lambda: self._device.get_feature(name).set_value_from_string(text))

    def execute(self, name: str) -> None:
        """Run a command."""
        _asked(lambda: self._device.execute_command(name))

    @cached_property
    def _clock(self) -> Any:
        return clock_features(self._names, self.read)

    def read_clock(self) -> Reading | None:
        """A timed reading of its clock; None if it cannot be read."""
        return None if self._clock is None else self._clock.read(self.execute, self.read)

    def start(self) -> None:
        """Begin to send pictures."""
        self._stream = _asked(lambda: self._camera.create_stream(None, None))
        payload = _asked(self._camera.get_payload)
        for _ in range(BUFFERS):
            memory = np.empty(payload, "u1")
            buffer = Aravis.Buffer.new(payload, memory.ctypes.data)
            self._memory[buffer] = memory
            self._stream.push_buffer(buffer)
        _asked(self._camera.start_acquisition)

    def next(self, timeout: float) -> Picture | None:
        """The next picture; None if none comes within `timeout`, s."""
        if self._buffer is not None:
            self._stream.push_buffer(self._buffer)
        self._buffer = buffer = self._stream.timeout_pop_buffer(round(timeout * 1e6))
        if buffer is None:
            return None
        arrival = time.monotonic_ns() - max(0, time.time_ns() - buffer.get_system_timestamp())
        identifier = buffer.get_frame_id()
        if buffer.get_status() != Aravis.BufferStatus.SUCCESS:
            return Picture(np.empty(0, "u1"), (0, 0), "", identifier, None, arrival, missing_packets=1)
        return Picture(
            self._memory[buffer],
            (buffer.get_image_width(), buffer.get_image_height()),
            format_name(buffer.get_image_pixel_format()),
            identifier,
            buffer.get_timestamp(),
            arrival,
            padding=int(buffer.get_image_padding()[0]),
        )

    def overruns(self) -> int:
        """Pictures since the start for which no buffer was free."""
        return int(self._stream.get_info_uint64_by_name("n_underruns"))

    def close(self) -> None:
        """Stop the pictures and release the camera."""
        try:
            if self._stream is not None:
                self._camera.stop_acquisition()
        except GLib.Error:
            pass  # it is gone
        self._buffer = self._stream = None  # ends the thread that fills the buffers
        self._camera = self._device = self._genicam = None
        self._memory.clear()
