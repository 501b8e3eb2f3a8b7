"""Recorded messages, found by port and capture time, with the memory of a few seconds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from followspot import Message
from followspot.errors import FollowspotError
from followspot.messages import InvalidMessage
from followspot.wire import unpack
from followspot_recording.recording import Recording

_HELD = 32 << 20
"""Bytes of each port that are held for firings that take an earlier message."""


class _Port:
    """The messages of one port, read as far as they were asked for. coming: its messages in order."""

    def __init__(self, coming: Iterator[tuple[int, memoryview]]) -> None:
        self._coming = coming
        self._held: dict[int, bytes] = {}
        self._read = -1
        """Capture time of the newest message that was read, ns."""
        self._bytes = 0
        self._asked: int | None = None

    def find(self, time: int) -> bytes | None:
        """The message of this capture time, ns; None if there is none, or if it was asked for too late."""
        while self._read < time and (found := next(self._coming, None)) is not None:
            self._read = found[0]
            self._held[found[0]] = bytes(found[1])
            self._bytes += len(found[1])
            self._forget()
        if time in self._held:
            self._asked = time
        return self._held.get(time)

    def _forget(self) -> None:
        """Drop the oldest messages beyond the limit, except the last one asked for, which may be sampled."""
        for time in list(self._held) if self._bytes > _HELD else ():
            if self._bytes <= _HELD or len(self._held) <= 2:
                break
            if time != self._asked:
                self._bytes -= len(self._held.pop(time))


class RecordedMessages:
    """The messages of some ports of a recording, asked for about in the order of their times.

    types: of the messages, by port (STAGE.PORT).
    """

    def __init__(self, recording: Recording, types: Mapping[str, type[Message]]) -> None:
        self._recording = recording
        self._types = types
        self._ports: dict[str, _Port] = {}
        self._others: dict[tuple[str, int], Message] = {}

    def add(self, messages: Mapping[tuple[str, int], Message]) -> None:
        """Replace the messages that are given beside the recorded ones. By port and capture time, ns."""
        self._others = dict(messages)

    def has(self, port: str, time: int) -> bool:
        """Whether there is a message of a port with this capture time, ns, and its type is known."""
        return port in self._types and (self._found(port, time) is not None or (port, time) in self._others)

    def given(self, port: str, time: int) -> Message:
        """The message of a port with this capture time, ns. Raises FollowspotError, KeyError without one."""
        data = self._found(port, time)
        if data is None:
            return self._others[port, time]
        try:
            message = unpack(data, self._types[port])
        except (InvalidMessage, KeyError) as error:
            where = f"{self._recording.path}: {port} at {time} ns"
            raise FollowspotError(f"{where} is damaged: {error}") from None
        assert isinstance(message, Message)
        return message

    def _found(self, port: str, time: int) -> bytes | None:
        if port not in self._ports:
            messages = self._recording.messages(port)
            self._ports[port] = _Port((one.time, one.data) for one in messages)
        return self._ports[port].find(time)
