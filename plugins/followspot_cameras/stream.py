"""A camera in the network."""

from __future__ import annotations

from urllib.parse import urlsplit

import cv2
from pydantic import field_validator

from followspot import Field, InputAddress, StageParams
from followspot_cameras.live import Capture, CaptureCamera
from followspot_cameras.reconnection import READ_TIMEOUT

SCHEMES = ("rtsp", "rtsps", "http", "https", "udp", "tcp")


class Stream(CaptureCamera):
    """Play a network stream (RTSP, HTTP, UDP, TCP); connects again when it breaks."""

    class Params(StageParams):
        url: InputAddress = Field(max_length=2000, description=f"address, one of {', '.join(SCHEMES)}")
        open_timeout: float = Field(5.0, gt=0, le=60, unit="s", description="longest wait for a connection")
        read_timeout: float = Field(
            2.0,
            gt=0,
            le=60,
            unit="s",
            description=READ_TIMEOUT,
        )

        @field_validator("url")
        @classmethod
        def known_scheme(cls, url: str) -> str:
            """Accept network streams only, because ffmpeg would also open files and devices by an address."""
            parts = urlsplit(url)
            if parts.scheme not in SCHEMES or not parts.hostname:
                raise ValueError(
                    f"a stream's address looks like rtsp://host/path; one of {', '.join(SCHEMES)}"
                )
            return url

    params: Params

    @property
    def origin(self) -> str:
        """The address without user name, password and query."""
        return public_address(self.params.url)

    def connect(self) -> Capture:
        """Open the stream; both waits are limited."""
        limits = {
            cv2.CAP_PROP_OPEN_TIMEOUT_MSEC: self.params.open_timeout,
            cv2.CAP_PROP_READ_TIMEOUT_MSEC: self.params.read_timeout,
        }
        milliseconds = [n for key, seconds in limits.items() for n in (key, round(seconds * 1000))]
        return cv2.VideoCapture(self.params.url, cv2.CAP_FFMPEG, milliseconds)


def public_address(url: str) -> str:
    """The address without credentials, which are in user info and query."""
    parts = urlsplit(url)
    host = parts.netloc.rpartition("@")[2]
    return f"{parts.scheme}://{host}{parts.path}"
