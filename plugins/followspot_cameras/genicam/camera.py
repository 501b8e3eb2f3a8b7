"""The interface of a backend: cameras that were found, connected cameras, and their pictures."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from followspot.messages import Array
from followspot_cameras.camera_features import Feature
from followspot_cameras.genicam.camera_clock import Reading


class CameraGone(ConnectionError):
    """The camera does not answer, or its stream has ended; the text says how that showed."""


def refused(text: str) -> CameraGone:
    """The error for a message of a camera or its backend, in words that users know."""
    if "access_denied" in text.lower().replace("-", "_"):
        return CameraGone(f"another program controls it ({text})")
    return CameraGone(text)


@dataclass(frozen=True)
class CameraInfo:
    """A camera that a backend found.

    identity: of the device, as the backend has it; transport: "GigE Vision" or "USB3 Vision"; address: in the
    network, or bus and device; empty texts are not known.
    """

    backend: str
    identity: str
    transport: str
    address: str
    vendor: str = ""
    model: str = ""
    serial: str = ""
    name: str = ""
    handle: Any = field(default=None, compare=False, repr=False)
    """Object by which the backend connects to the camera."""

    @property
    def words(self) -> tuple[str, ...]:
        """The words by which a user may name it."""
        return tuple(word for word in (self.serial, self.name, self.address, self.identity) if word)

    def __str__(self) -> str:
        told = " ".join(word for word in (self.vendor, self.model, self.serial) if word)
        return f"{told or self.identity} at {self.address}"


class Picture(NamedTuple):
    """One picture as it came.

    data: (B,) uint8, valid until the next picture; size: width and height, px; format: its PFNC name;
    identifier: the camera's number of it; camera_time: by the camera's clock, ns, None if it says none;
    arrival: by this host's steady clock, ns; missing_packets: of those that it was sent in; padding:
    bytes after each line of pixels.
    """

    data: Array
    size: tuple[int, int]
    format: str
    identifier: int
    camera_time: int | None
    arrival: int
    missing_packets: int = 0
    padding: int = 0


class VisionCamera(Protocol):
    """A connected camera. Every method raises CameraGone if the camera does not answer."""

    largest_identifier: int
    """After which the identifiers of its pictures begin again at 1; 0 if they do not."""

    def names(self) -> Collection[str]:
        """Names of all its features."""

    def feature(self, name: str) -> Feature | None:
        """One of its features."""

    def read(self, name: str) -> str:
        """The value of a feature, as text."""

    def write(self, name: str, text: str) -> None:
        """Set a feature. Raises ValueError if the camera refuses the value."""

    def execute(self, name: str) -> None:
        """Run a command."""

    def read_clock(self) -> Reading | None:
        """A timed reading of its clock; None if it cannot be read."""

    def start(self) -> None:
        """Begin to send pictures."""

    def next(self, timeout: float) -> Picture | None:
        """The next picture; None if none comes within `timeout`, s."""

    def overruns(self) -> int:
        """Pictures since the start that were given up here, because they were not taken in time."""

    def close(self) -> None:
        """Stop the pictures and release the camera."""


class Backend(Protocol):
    """A program that speaks to cameras: a module with these functions."""

    def discover(self, interface: str, timeout: float) -> list[CameraInfo]:
        """Cameras in sight. interface: own address, "" for all; timeout: s."""

    def described(self, info: CameraInfo) -> CameraInfo:
        """The camera with the serial number and the name that it gives itself, if it answers."""

    def connect_read_only(self, info: CameraInfo) -> VisionCamera:
        """The camera, for reading only, if possible while another program controls it. Raises CameraGone."""

    def addressed(self, address: str) -> CameraInfo | None:
        """The camera at an address, which may be behind routers that pass no search; None if unasked."""

    def connect(self, info: CameraInfo, interface: str, packet_size: int) -> VisionCamera:
        """The camera. Raises CameraGone."""
