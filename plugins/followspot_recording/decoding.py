"""The messages of a recorded port, as the types that they were."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from followspot import Message
from followspot.errors import FollowspotError
from followspot.messages import InvalidMessage
from followspot.wire import unpack
from followspot_recording.recording import Recording

M = TypeVar("M", bound=Message)


def decoded(
    recording: Recording, port: str, kind: type[M], start: int = 0, stop: int | None = None
) -> Iterator[M]:
    """The messages of a port from `start` up to and with `stop`, ns, in order.

    Raises FollowspotError with file, port and message if one is of another type.
    """
    for recorded in recording.messages(port, start, stop):
        try:
            message = unpack(bytes(recorded.data), kind)
        except InvalidMessage as error:
            raise FollowspotError(
                f"{recording.path}: message {recorded.seq} of {port} is none: {error}"
            ) from None
        assert isinstance(message, kind)
        yield message
