"""Stage `cameras.rtsp`: a network camera, with capture times from its own clock."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing
from urllib.parse import urlsplit

from pydantic import field_validator

from followspot import Field, InputAddress, Source, StageParams, at
from followspot.tracking import Frame
from followspot_cameras.picture import as_frame
from followspot_cameras.reconnection import LiveCamera
from followspot_cameras.rtsp.access_units import AccessUnit, AccessUnits
from followspot_cameras.rtsp.connection import PORTS, ConnectionLost, RtspConnection
from followspot_cameras.rtsp.decoder import Decoder
from followspot_cameras.rtsp.report_times import ReportTimes
from followspot_cameras.rtsp.rtp import rtp_packet, sender_report
from followspot_cameras.rtsp.session_description import NoVideo, Video, video_of
from followspot_cameras.stream import public_address

LONGEST_LOOK = 0.2
"""Longest wait for a packet before the stage looks whether the run ends, s."""
KEEP_ALIVE = 25.0
"""Between requests that keep a session alive, s; servers end it after 60 s (RFC 2326, section 12.37)."""
TRANSPORT = "RTP/AVP/TCP;unicast;interleaved=0-1"
PICTURES, REPORTS = 0, 1
"""Channels of RTP and RTCP."""


class Rtsp(LiveCamera):
    """Pictures of a network camera (H.264 or H.265 over RTSP and TCP), connected again when it vanishes.

    The camera's sender reports tell when each picture was captured by the camera's clock; their arrival tells
    how far that clock is off.
    """

    class Params(StageParams):
        url: InputAddress = Field(
            max_length=2000, description="address, rtsp:// or rtsps://, with user and password if need be"
        )
        open_timeout: float = Field(5.0, gt=0, le=60, unit="s", description="longest wait for a connection")
        read_timeout: float = Field(2.0, gt=0, le=60, unit="s", description="longest wait for a picture")
        wait_for_report: float = Field(
            6.0,
            ge=0,
            le=60,
            unit="s",
            description="how long pictures are left out until the camera tells its clock, or arrival counts",
        )

        @field_validator("url")
        @classmethod
        def known_scheme(cls, url: str) -> str:
            """Accept addresses of RTSP only."""
            parts = urlsplit(url)
            if parts.scheme not in PORTS or not parts.hostname or any(c in url for c in "\r\n "):
                raise ValueError("an address of a camera looks like rtsp://host/path")
            return url

    params: Params

    @property
    def origin(self) -> str:
        """The address without user name, password and query."""
        return public_address(self.params.url)

    def process(self) -> Source[Frame]:
        """Pictures as they come, with capture times by this computer's clock."""
        self._times = ReportTimes(round(self.params.wait_for_report * 1e9), self.say)
        yield from super().process()

    def session(self) -> Iterator[Frame]:
        """Pictures of one connection, with capture times by this computer's clock. Raises ConnectionLost."""
        p = self.params
        with closing(RtspConnection(p.url, p.open_timeout, p.read_timeout)) as connection:
            video = _playing(connection)
            self._times.begin(video.rate, time.time_ns())
            decoder = Decoder(video)
            try:
                for unit in self._units(connection, video):
                    self.context.lost("packet_loss", int(unit.damaged))
                    yield from self._frames(unit, decoder)
            finally:
                if decoder.errors:
                    self.say(f"{decoder.errors} pictures could not be decoded")

    def _units(self, connection: RtspConnection, video: Video) -> Iterator[AccessUnit]:
        """The pictures of the video, as they come."""
        units = AccessUnits(video.codec)
        heard = kept = time.monotonic()
        while not self.stopped.is_set():
            packet = connection.packet(min(LONGEST_LOOK, self.params.read_timeout))
            now = time.monotonic()
            if now - heard > self.params.read_timeout:
                raise ConnectionLost(f"no picture came for {self.params.read_timeout:g} s")
            if now - kept > KEEP_ALIVE:
                connection.send("GET_PARAMETER")
                kept = now
            if packet is None:
                continue
            if packet.channel == REPORTS:
                report = sender_report(packet.data)
                if report is not None:
                    self._times.report(report, packet.arrival)
            elif packet.channel == PICTURES:
                found = rtp_packet(packet.data)
                if found is not None and found.payload_type == video.payload_type:
                    heard = now
                    unit = units.add(found, packet.arrival)
                    if unit is not None:
                        yield unit

    def _frames(self, unit: AccessUnit, decoder: Decoder) -> Iterator[Frame]:
        for source, image in decoder.decode(unit):
            captured = None if source.damaged else self._times.capture_time(source)
            if captured is not None:
                yield at(captured, as_frame(image, self.camera, self.context.loan, self.origin))


def _playing(connection: RtspConnection) -> Video:
    """The video that the server sends from now on. Raises ConnectionLost."""
    answer = connection.request("DESCRIBE", Accept="application/sdp")
    base = answer.headers.get("content-base") or answer.headers.get("content-location") or connection.url
    try:
        video = video_of(answer.body, base)
    except NoVideo as error:
        raise ConnectionLost(str(error)) from None
    connection.request("SETUP", video.control, Transport=TRANSPORT)
    connection.request("PLAY", Range="npt=0.000-")
    return video
