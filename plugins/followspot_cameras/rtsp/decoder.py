"""Decoding of pictures by PyAV (FFmpeg), one by one and without waiting for later ones."""

from __future__ import annotations

from collections.abc import Iterator

import av

from followspot.messages import Array
from followspot_cameras.rtsp.access_units import AccessUnit
from followspot_cameras.rtsp.session_description import Video

MOST_PIXELS = 1 << 26
"""Of one picture: a few bytes may claim billions, for which a decoder would take memory."""


class Decoder:
    """The decoder of one session.

    errors: pictures that could not be decoded; those before the first key frame do not count.
    """

    def __init__(self, video: Video) -> None:
        context = av.CodecContext.create(video.codec, "r")
        assert isinstance(context, av.VideoCodecContext), "the codecs of descriptions are of videos"
        self._context = context
        self._context.thread_type = "SLICE"
        self._context.options = {"max_pixels": str(MOST_PIXELS)}
        self._parameters = video.parameters
        self._began = False
        self._units: dict[int, AccessUnit] = {}
        self._number = 0
        self.errors = 0

    def decode(self, unit: AccessUnit) -> Iterator[tuple[AccessUnit, Array]]:
        """The pictures that a unit completes, (H, W, 3) BGR, each with the unit that it came in."""
        data, self._parameters = self._parameters + unit.data, b""
        packet = av.Packet(data)
        packet.pts = self._number
        self._units[self._number] = unit
        self._number += 1
        try:
            frames = self._context.decode(packet)
        except av.error.FFmpegError:
            self.errors += self._began
            return
        for frame in frames:
            self._began = True
            if frame.pts in self._units:
                yield self._units.pop(frame.pts), frame.to_ndarray(format="bgr24")
        oldest = self._number - 64
        self._units = {number: kept for number, kept in self._units.items() if number > oldest}
