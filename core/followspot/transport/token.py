"""What travels on an edge besides messages: watermarks, and what arrived broken."""

from __future__ import annotations

from typing import NamedTuple

from followspot.messages import MAX_TIME, Message

END = 2**63 - 1
"""The bound, ns, of a stream that is over."""
ABSENT = END - 1
"""The bound, ns, of a stream whose source is away: nothing comes for now; whatever comes next ends that."""
MAX_LATENESS = 1 << 61
"""What the windows of all joins of a graph can add to a capture time, ns."""
MAX_WATERMARK = MAX_TIME + MAX_LATENESS
"""Largest bound, ns, that a message leads to; `ABSENT` and `END` lie beyond."""

MAX_COUNT = 1 << 62
"""Largest count that one end tells the other: what is added to it still fits into the next."""


class Watermark(NamedTuple):
    """Nothing earlier than `time` (ns) will come; `END` for the end of the stream."""

    time: int


def is_watermark(number: int) -> bool:
    """Whether a writer may say so: what a message leads to, the absence, or the end."""
    return -MAX_WATERMARK <= number <= MAX_WATERMARK or number in (ABSENT, END)


class Invalid(NamedTuple):
    """Stands, at the reader, for a message that was lost or breaks its contract; the text says why.

    missing: whether it was lost on its way.
    """

    reason: str
    missing: bool = False


Token = Message | Watermark | Invalid
"""What a reader hands out; a sealed message settles its own time, so the edge's bound is time + 1."""
