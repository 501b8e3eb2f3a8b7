"""What every edge between workers offers, whatever carries it: the writing end and the reading end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from followspot.messages import Array
from followspot.transport.token import Settled, Token


class PortWriter(Protocol):
    """All edges of one kind that leave one output port. No call blocks."""

    def credit(self) -> int:
        """Messages that may be sent now without exceeding the depth of the slowest living reader."""

    def send(self, token: Token | Settled) -> None:
        """Send a sealed message (only with credit) or a settled time (always taken, coalesced if need be)."""

    def flush(self) -> bool:
        """Retry what could not be written at once; True when nothing is pending."""

    def loan(self, shape: tuple[int, ...], dtype: str) -> Array | None:
        """A writable array in the memory that is sent from, or None where there is none free."""

    def filenos(self) -> list[int]:
        """Descriptors that become readable when credit may have come."""

    def drain(self) -> None:
        """Swallow the wake-ups of `filenos`."""

    def want_credit(self) -> None:
        """Ask the readers to wake us; look at `credit` again afterwards."""

    @property
    def lost(self) -> Sequence[int]:
        """Numbers of the readers that died."""

    def close(self) -> None:
        """Release everything."""


class PortReader(Protocol):
    """The reading end of one edge. No call blocks."""

    def poll(self) -> list[Token]:
        """Everything that has arrived."""

    def fileno(self) -> int:
        """A descriptor that becomes readable when something arrives."""

    def consumed(self, count: int = 1) -> None:
        """Give credit back: the stage has taken so many messages."""

    @property
    def lost(self) -> bool:
        """Whether the writer died before its end of stream."""

    def close(self) -> None:
        """Release everything; arrays already handed out stay valid."""
