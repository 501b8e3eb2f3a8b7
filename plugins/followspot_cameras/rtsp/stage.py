"""Stage `cameras.rtsp`: a network camera, with capture times from its own clock."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing
from typing import Literal, Self
from urllib.parse import urlsplit

from pydantic import field_validator, model_validator

from followspot import Field, InputAddress, Source, StageParams, at
from followspot.frame_times import to_ns
from followspot.tracking import Frame
from followspot_cameras.picture import as_frame
from followspot_cameras.reconnection import READ_TIMEOUT, LiveCamera
from followspot_cameras.rtsp.access_units import AccessUnit, AccessUnits
from followspot_cameras.rtsp.connection import PORTS, ConnectionLost, RtspConnection
from followspot_cameras.rtsp.datagrams import Datagrams
from followspot_cameras.rtsp.decoder import Decoder
from followspot_cameras.rtsp.report_times import ReportTimes
from followspot_cameras.rtsp.rtp import rtp_packet, sender_report
from followspot_cameras.rtsp.session_description import NoVideo, Video, video_of
from followspot_cameras.rtsp.transport import PICTURES, REPORTS, Interleaved, Transport
from followspot_cameras.stream import public_address

LONGEST_LOOK = 0.2
"""Longest wait for a packet before the stage looks whether the run ends, s."""
KEEP_ALIVE = 25.0
"""Between requests that keep a session alive, s; servers end it after 60 s (RFC 2326, section 12.37)."""


class Rtsp(LiveCamera):
    """Pictures of a network camera (H.264 or H.265 over RTSP), connected again when it vanishes.

    The sender reports of the camera give the capture time of each picture by the camera's clock. The times at
    which the reports arrive give the offset of that clock.
    """

    class Params(StageParams):
        url: InputAddress = Field(
            max_length=2000, description="address, rtsp:// or rtsps://, with user and password if need be"
        )
        open_timeout: float = Field(5.0, gt=0, le=60, unit="s", description="longest wait for a connection")
        read_timeout: float = Field(
            2.0,
            gt=0,
            le=60,
            unit="s",
            description=READ_TIMEOUT,
        )
        wait_for_report: float = Field(
            6.0,
            ge=0,
            le=60,
            unit="s",
            description="how long pictures are left out until the camera tells its clock, or arrival counts",
        )
        transport: Literal["tcp", "udp"] = Field(
            "tcp", description="tcp loses nothing and may wait; udp waits for nothing and may lose pictures"
        )
        jitter_buffer: float = Field(
            0.1,
            ge=0,
            le=5,
            unit="s",
            description="over udp, the longest wait for a packet that other packets overtook",
        )

        @field_validator("url")
        @classmethod
        def known_scheme(cls, url: str) -> str:
            """Accept addresses of RTSP only."""
            parts = urlsplit(url)
            if parts.scheme not in PORTS or not parts.hostname or any(c in url for c in "\r\n "):
                raise ValueError("an address of a camera looks like rtsp://host/path")
            return url

        @model_validator(mode="after")
        def protected(self) -> Self:
            """Refuse pictures by UDP beside a protected connection: they would come unprotected."""
            if self.transport == "udp" and self.url.startswith("rtsps:"):
                raise ValueError("pictures of rtsps:// come over tcp: by udp, nothing protects them")
            return self

    params: Params

    @property
    def origin(self) -> str:
        """The address without user name, password and query."""
        return public_address(self.params.url)

    def process(self) -> Source[Frame]:
        """Pictures as they come, with capture times by this host's clock."""
        self._times = ReportTimes(to_ns(self.params.wait_for_report), self.say)
        yield from super().process()

    def session(self) -> Iterator[Frame]:
        """Pictures of one connection, with capture times by this host's clock. Raises ConnectionLost."""
        p = self.params
        with (
            closing(RtspConnection(p.url, p.open_timeout, p.read_timeout)) as connection,
            closing(self._transport(connection)) as transport,
        ):
            video = _playing(connection, transport)
            self._times.begin(video.rate, time.time_ns())
            decoder = Decoder(video)
            try:
                for unit in self._units(connection, transport, video):
                    self.context.lost("packet_loss", unit.lost)
                    before = decoder.errors
                    yield from self._frames(unit, decoder)
                    self.context.lost("packet_loss", 0 if unit.damaged else decoder.errors - before)
            finally:
                if decoder.errors:
                    self.say(f"{decoder.errors} pictures could not be decoded")
                if transport.late:
                    self.say(f"{transport.late} packets came twice, or later than the jitter buffer waits")

    def _transport(self, connection: RtspConnection) -> Transport:
        if self.params.transport == "udp":
            return Datagrams(connection, self.params.jitter_buffer)
        return Interleaved(connection)

    def _units(self, connection: RtspConnection, transport: Transport, video: Video) -> Iterator[AccessUnit]:
        """The pictures of the video, as they come."""
        units = AccessUnits(video.codec)
        heard = kept = time.monotonic()
        while not self.stopped.is_set():
            packet = transport.packet(min(LONGEST_LOOK, self.params.read_timeout))
            now = time.monotonic()
            if now - kept > KEEP_ALIVE:
                connection.send("GET_PARAMETER")
                kept = now
            found = rtp_packet(packet.data) if packet is not None and packet.channel == PICTURES else None
            if packet is not None and found is not None and found.payload_type == video.payload_type:
                unit = units.add(found, packet.arrival)
                if unit is not None:
                    yield unit
                heard = time.monotonic()  # not while the graph held this picture
                continue
            if packet is not None and packet.channel == REPORTS:
                report = sender_report(packet.data)
                if report is not None:
                    self._times.report(report, packet.arrival)
            if now - heard > self.params.read_timeout:
                raise ConnectionLost(self._silence)

    @property
    def _silence(self) -> str:
        text = f"no picture came for {self.params.read_timeout:g} s"
        return f"{text} (is UDP let through? else transport: tcp)" if self.params.transport == "udp" else text

    def _frames(self, unit: AccessUnit, decoder: Decoder) -> Iterator[Frame]:
        for source, image in decoder.decode(unit) if unit.data else ():
            captured = None if source.damaged else self._times.capture_time(source)
            if captured is not None:
                yield at(captured, as_frame(image, self.camera, self.context.loan, self.origin))


def _playing(connection: RtspConnection, transport: Transport) -> Video:
    """The video that the server sends from now on. Raises ConnectionLost."""
    answer = connection.request("DESCRIBE", Accept="application/sdp")
    base = answer.headers.get("content-base") or answer.headers.get("content-location") or connection.url
    try:
        video = video_of(answer.body, base)
    except NoVideo as error:
        raise ConnectionLost(str(error)) from None
    agreed = connection.request("SETUP", video.control, Transport=transport.wanted)
    transport.agreed(agreed.headers.get("transport", ""))
    connection.request("PLAY", Range="npt=0.000-")
    return video
