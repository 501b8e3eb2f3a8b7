"""A recording on the page: what its ports said last at a capture time that browsers choose."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from followspot import Message
from followspot.frame_times import to_ns, to_seconds
from followspot.messages import InvalidMessage
from followspot.wire import pack, unpack
from followspot_dashboard.picture import PICTURES, picture_of
from followspot_page.allowed_requests import Seek
from followspot_page.taps.shown_ports import ShownPort, longest_side
from followspot_recording.recording import Recording
from followspot_recording.records import Recorded

_REACHES = (0.15, 1.5)
"""Seconds before a moment in which a port's last message is looked for; older ones are not shown."""
_RENEWED = 1.0
"""Seconds after which a position that stays the same is sent again: else browsers call it old."""


@dataclass(frozen=True)
class Position:
    """Position in a recording. time: capture time, ns; playing: whether it goes on from there."""

    time: int
    playing: bool = False


class Scrub:
    """Shows the messages of a recording around a moment, and plays from there at its own rate.

    ports: that can be shown; take: receives each port with its packed preview; publish: receives the position
    for browsers, JSON; rate: moments a second while it plays.
    """

    def __init__(
        self,
        recording: Recording,
        ports: Sequence[ShownPort],
        take: Callable[[str, bytes], Any],
        publish: Callable[[str], Any],
        rate: float,
    ) -> None:
        self.begin, self.end = recording.begin, recording.end
        self._recording = recording
        self.ports = [port for port in ports if port.name in recording.ports]
        self._take = take
        self._publish = publish
        self._period = 1.0 / rate
        self._position = Position(self.begin)
        self._sought = asyncio.Event()
        self._shown: dict[str, tuple[int, bytes]] = {}
        """Capture time and preview of the newest message of each port."""
        self._malformed: dict[str, str] = {}
        """The first mistake of each port that has sent messages that cannot be read."""

    @property
    def about(self) -> dict[str, float]:
        """Begin and end of the recording, s of capture time."""
        return {"begin": to_seconds(self.begin), "end": to_seconds(self.end)}

    @property
    def problems(self) -> list[str]:
        """Problems of the recording, as far as it was read: it is cut short, damaged, or malformed."""
        broken = [f"{port} cannot be read: {why}" for port, why in self._malformed.items()]
        return [self._recording.problem, *broken] if self._recording.problem else broken

    def seek(self, asked: Seek) -> str:
        """Go to a moment, None for where it stands, and play from there or stand still."""
        start = self._position.time
        if asked.seek is not None:
            within = min(
                max(asked.seek, to_seconds(self.begin)), to_seconds(self.end)
            )  # no float is too large for it
            start = min(max(self.begin, to_ns(within)), self.end)
        elif asked.play and start >= self.end:
            start = self.begin
        self._position = Position(start, asked.play)
        self._sought.set()
        return ""

    async def serve(self) -> None:
        """Show the position as it moves, for ever."""
        while True:
            position, started = self._position, time.monotonic()
            for port, packed in await asyncio.to_thread(lambda at: list(self._seen(at)), position.time):
                self._take(port, packed)
            said = {"type": "position", "at": to_seconds(position.time), "playing": position.playing}
            self._publish(json.dumps(said))
            await self._wait(self._period if position.playing else _RENEWED)
            if position is self._position and position.playing:
                later = min(position.time + to_ns(time.monotonic() - started), self.end)
                self._position = Position(later, later < self.end)

    async def _wait(self, seconds: float) -> None:
        """Until another moment is asked for, or so long."""
        self._sought.clear()
        try:
            async with asyncio.timeout(seconds):
                await self._sought.wait()
        except TimeoutError:
            pass

    def _seen(self, moment: int) -> Iterator[tuple[str, bytes]]:
        """The preview of each port that has said something lately, at a capture time, ns."""
        for port in self.ports:
            found = self._newest(port.name, moment)
            if found is None:
                continue
            known = self._shown.get(port.name)
            if known is None or known[0] != found.time:
                preview = self._preview(port, bytes(found.data))
                if preview is None:
                    continue
                known = self._shown[port.name] = found.time, pack(preview)
            yield port.name, known[1]

    def _preview(self, port: ShownPort, packed: bytes) -> Message | None:
        """A message as browsers get it; None if nothing of it can be shown."""
        try:
            message = unpack(packed, port.type)
        except InvalidMessage as error:
            self._malformed.setdefault(port.name, str(error))
            return None
        if isinstance(message, PICTURES):
            return picture_of(message, longest_side(port.size), port.farthest)
        return message if isinstance(message, Message) else None

    def _newest(self, port: str, moment: int) -> Recorded | None:
        """The newest message of a port at a capture time, ns; None if it is too old."""
        for reach in _REACHES:
            found = None
            for found in self._recording.messages(port, moment - to_ns(reach), moment):  # noqa: B007
                pass
            if found is not None:
                return found
        return None
