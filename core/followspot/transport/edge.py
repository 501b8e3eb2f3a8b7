"""The two ends of an edge between workers, alike for the ring and for Zenoh.

One writer serves all readers of an output port; each reader gets every token, in order. Messages need
credit: at most `depth` of them are on their way to the slowest reader. Watermarks need none. Nothing
here blocks: the runtime polls file descriptors and asks again. A peer that dies is `lost`, no exception.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from followspot.messages import Array, Message
from followspot.transport.token import Token, Watermark


class PortWriter(Protocol):
    """The writing end of all edges of one kind from one output port.

    To sleep until credit comes: `want_credit()`, look at `credit()` once more, poll `filenos()` with a time
    limit (100 ms), `drain()`. To finish: send `Settled(END)`, `flush()` until it is true, `close()`.
    """

    @property
    def lost(self) -> frozenset[int]:
        """Readers, by their index, that `drain` found gone before the end; they hold up nothing any more."""

    @property
    def strangers(self) -> int:
        """How much came that was malformed or not from a reader; no ledger knows it."""

    def perished(self) -> list[tuple[int, int]]:
        """Readers, by their index, that died, and how many messages were on their way to each; told once.

        After `close` also those that were cut off and did not come back. A reader may have taken one or two
        more than it had said.
        """

    def matched(self) -> bool:
        """Whether every reader is there; until then what is sent may miss it."""

    def credit(self) -> int:
        """How many messages may be sent now; the depth where no reader is left."""

    def send(self, token: Message | Watermark) -> None:
        """Send a sealed, stamped message, which needs credit, or a watermark.

        Watermarks that have to wait are merged. Raises InvalidMessage where a message cannot be put on
        the wire (a head of over 64 kB), and RuntimeError where it has no credit; nothing was sent then.
        """

    def loan(self, shape: Sequence[int], dtype: str) -> Array | None:
        """A writable array to compute an output into, to be sent without a copy; None if there is none."""

    def flush(self) -> bool:
        """Send what had to wait. True when nothing waits."""

    def filenos(self) -> list[int]:
        """File descriptors that become readable when credit came, a reader died, or `flush` may go on."""

    def want_credit(self) -> None:
        """Ask to be woken through `filenos()` by the next credit."""

    def drain(self) -> None:
        """Swallow the wake-ups, notice who died, and send what had to wait."""

    def close(self) -> None:
        """Let go of everything; loans and messages in other hands stay valid."""


class PortReader(Protocol):
    """The reading end of one edge."""

    @property
    def lost(self) -> bool:
        """Whether the writer is gone without having ended the stream; `poll` still gives what had arrived."""

    @property
    def broken(self) -> bool:
        """Whether nothing will ever come from here any more, not even when the writer is started again."""

    @property
    def strangers(self) -> int:
        """How much came that was malformed or not from the writer; no ledger knows it."""

    def matched(self) -> bool:
        """Whether the writer is there."""

    def poll(self) -> list[Token]:
        """What has arrived: each message that was sent, or an `Invalid` in its place, and watermarks."""

    def fileno(self) -> int:
        """Readable when `poll` has something to give, or the writer died."""

    def consumed(self, count: int = 1) -> None:
        """Give credit for messages, or `Invalid`s in their place, that were taken out of the queue."""

    def close(self) -> None:
        """Let go of everything; messages in other hands stay valid."""
