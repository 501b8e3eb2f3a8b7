"""The two ends of an edge between workers, alike for the ring and for Zenoh.

One writer serves all readers of an output port; each reader gets every token, in order. Backpressure is
credit: at most `depth` messages are on their way to the slowest reader. Watermarks need no credit. No call
blocks: the scheduler polls file descriptors and asks again. A peer that dies is `lost`, which raises nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from followspot.messages import Array, Message
from followspot.transport.token import UNKNOWN, Token, Watermark


class PortWriter(Protocol):
    """The writing end of all edges of one kind from one output port.

    To sleep until credit comes: `want_credit()`, ask `credit()` once more, poll `filenos()` with a time
    limit (100 ms), `drain()`. To finish: send `Watermark(END)`, `flush()` until it is true, `close()`.
    """

    @property
    def lost(self) -> frozenset[int]:
        """Indices of readers that `drain` found gone before the end; the writer no longer waits for them."""

    @property
    def rejected(self) -> int:
        """Count of all that came malformed or not from a reader; no ledger has it."""

    def newly_dead(self) -> list[tuple[int, int]]:
        """Indices of readers that died since the last call, each with its messages that were on their way.

        After `close` also readers that were cut off and did not come back. A reader may have taken one or two
        messages more than it had reported.
        """

    def matched(self) -> bool:
        """Whether every reader is there; tokens that are sent before may not reach it."""

    def credit(self) -> int:
        """How many messages may be sent now; the depth if no reader is left."""

    def send(self, token: Message | Watermark, watermark: int = UNKNOWN) -> None:
        """Send a sealed, stamped message, which needs credit, or a watermark.

        watermark: the one after a message, ns, if it is known already: it travels with the message, and
        readers get it as the next token. Watermarks that have to wait are merged. Raises InvalidMessage if a
        message cannot be put on the wire (a head of over 64 kB), and RuntimeError if it has no credit;
        nothing is sent then.
        """

    def loan(self, shape: Sequence[int], dtype: str) -> Array | None:
        """A writable array for an output, which is sent without a copy; None if there is none."""

    def flush(self) -> bool:
        """Send tokens that had to wait. True when none waits."""

    @property
    def all_taken(self) -> bool:
        """False if a reader has not reported yet that it has taken everything sent; see `report_at_once`."""

    def dismiss(self, index: int) -> None:
        """Send a reader nothing more and wait for it no longer: its edge has left the graph."""

    def filenos(self) -> list[int]:
        """File descriptors that become readable when credit comes, a reader dies, or `flush` may go on."""

    def want_credit(self) -> None:
        """Ask for a wake-up through `filenos()` at the next credit."""

    def drain(self) -> None:
        """Clear wake-ups, notice which readers died, and send tokens that had to wait."""

    def close(self) -> None:
        """Close this end; loans and messages that a stage still holds stay valid."""


class PortReader(Protocol):
    """The reading end of one edge."""

    @property
    def lost(self) -> bool:
        """Whether the writer is gone without ending the stream; `poll` still gives arrived messages."""

    @property
    def broken(self) -> bool:
        """Whether this reader can get nothing more: a writer that is started again needs a new reader."""

    @property
    def rejected(self) -> int:
        """Count of all that came malformed or not from the writer; no ledger has it."""

    def matched(self) -> bool:
        """Whether the writer is there."""

    def poll(self) -> list[Token]:
        """Tokens that have arrived: each message, or an `Invalid` in its place, and watermarks."""

    @property
    def caught_up(self) -> bool:
        """False if `poll` is known not to have taken everything that was sent so far."""

    def report_at_once(self, at_once: bool) -> None:
        """Report every token to the writer as soon as it is taken (True), or only now and then (False)."""

    def fileno(self) -> int:
        """File descriptor, readable when `poll` has tokens or the writer died."""

    def consumed(self, count: int = 1) -> None:
        """Give credit for messages that left the queue, or for an `Invalid` in their place."""

    def close(self) -> None:
        """Close this end; messages that a stage still holds stay valid."""
