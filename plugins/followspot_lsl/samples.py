"""The message type of samples of a stream of the Lab Streaming Layer."""

from __future__ import annotations

from followspot.messages import Array, Message, column


class Samples(Message):
    """Samples of one stream, a row for each channel of each sample; the message has the time of the last."""

    stream: str
    channels: tuple[str, ...]
    """Labels of the channels, or their numbers from 0."""
    time: Array = column("N", dtype="i8", unit="ns", names="sample_time")
    """Capture time of each sample."""
    channel: Array = column("N", dtype="i4", refers="channels")
    value: Array = column("N")
    """In the unit of the channel, which the stream may say."""
