"""The record of one firing of a stage: with the messages that it names, the firing can be repeated."""

from __future__ import annotations

from followspot.messages import Array, Message, column

FIRINGS = "-firings"
"""Stands for a port in the names of taps; no port has such a name."""


def firings_of(stage: str) -> str:
    """The name under which a stage's firings are tapped and recorded."""
    return f"{stage}.{FIRINGS}"


def is_firings(port: str) -> bool:
    """Whether the name stands for the firings of a stage, and for no port."""
    return port.endswith(f".{FIRINGS}")


class Firing(Message):
    """The messages that a firing took, in order. Its header has the number and capture time of the firing.

    checkpoint: the stage before this firing as JSON (`followspot.worker.stage_checkpoint.Checkpoint`), empty
    if the firings before it lead there; edge: of each message, the row in the newest checkpoint's edges;
    captured: its capture time.
    """

    checkpoint: Array = column("B", dtype="u1")
    edge: Array = column("N", dtype="i4")
    captured: Array = column("N", dtype="i8", unit="ns")
