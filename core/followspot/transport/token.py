"""What travels on an edge besides messages: settled times, and what arrived broken."""

from __future__ import annotations

from typing import NamedTuple

from followspot.messages import Message

END = 2**63 - 1
"""The bound, ns, of a stream that is over."""
ABSENT = END - 1
"""The bound, ns, of a stream whose source is away: nothing comes for now; whatever comes next ends that."""


class Settled(NamedTuple):
    """Nothing earlier than `bound` (ns) will come; `END` for the end of the stream."""

    bound: int


class Invalid(NamedTuple):
    """Stands, at the reader, for a message that was lost or breaks its contract; the text says why."""

    reason: str


Token = Message | Settled | Invalid
"""What a reader hands out; a sealed message settles its own time, so the edge's bound is time + 1."""
