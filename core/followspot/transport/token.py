"""What travels on an edge besides messages: settled times, and what arrived broken."""

from __future__ import annotations

from typing import NamedTuple

from followspot.messages import MAX_TIME, Message

END = 2**63 - 1
"""The bound, ns, of a stream that is over."""
ABSENT = END - 1
"""The bound, ns, of a stream whose source is away: nothing comes for now; whatever comes next ends that."""
MAX_SLACK = 1 << 61
"""What the windows of all joins of a graph can add to a capture time, ns."""
MAX_BOUND = MAX_TIME + MAX_SLACK
"""Largest bound, ns, that a message leads to; `ABSENT` and `END` lie beyond."""

MAX_COUNT = 1 << 62
"""Largest count that one end tells the other: what is added to it still fits into the next."""


class Settled(NamedTuple):
    """Nothing earlier than `bound` (ns) will come; `END` for the end of the stream."""

    bound: int


def is_bound(number: int) -> bool:
    """Whether a writer may say so: what a message leads to, the absence, or the end."""
    return -MAX_BOUND <= number <= MAX_BOUND or number in (ABSENT, END)


class Invalid(NamedTuple):
    """Stands, at the reader, for a message that was lost or breaks its contract; the text says why.

    missing: whether it was lost on its way.
    """

    reason: str
    missing: bool = False


Token = Message | Settled | Invalid
"""What a reader hands out; a sealed message settles its own time, so the edge's bound is time + 1."""
