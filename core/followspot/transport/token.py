"""Tokens of an edge besides messages: watermarks, and what stands for an invalid message."""

from __future__ import annotations

from typing import NamedTuple

from followspot.messages import MAX_TIME, Message

END = 2**63 - 1
"""Watermark, ns, of a stream that has ended."""
UNKNOWN = -END
"""Stands for the watermark after a message while that is not known."""
ABSENT = END - 1
"""Watermark, ns, of a stream whose source is away: nothing comes for now; the next token ends the absence."""
MAX_LATENESS = 1 << 61
"""Largest sum of the windows of joins along a path of a graph, ns."""
MAX_WATERMARK = MAX_TIME + MAX_LATENESS
"""Latest watermark, ns, that a message can lead to; `ABSENT` and `END` lie beyond."""

MAX_COUNT = 1 << 62
"""Largest count that one end reports to the other; sums of two still fit into 64 bits."""


class Watermark(NamedTuple):
    """Nothing earlier than `time`, ns, will come; `END` ends the stream, `ABSENT`: its source is away."""

    time: int


def is_watermark(number: int) -> bool:
    """Whether `number` can be a watermark, ns: a time in range, `ABSENT` or `END`."""
    return -MAX_WATERMARK <= number <= MAX_WATERMARK or number in (ABSENT, END)


class Invalid(NamedTuple):
    """Takes the place of a message that was lost on its way (`missing`) or breaks its contract."""

    reason: str
    missing: bool = False


Token = Message | Watermark | Invalid
"""A token that a reader gives; a message advances the edge's watermark to its time + 1 + allowed lateness."""
