"""The writing end of the ring: it writes a frame into shared memory once, for all readers of a port."""

from __future__ import annotations

import socket
from collections.abc import Sequence
from math import prod

import numpy as np

from followspot.messages import MAX_BYTES, Array, Message
from followspot.transport.ring.control import CONSUMED
from followspot.transport.ring.heads import HeadPacker
from followspot.transport.ring.links import ReaderLinks, ReaderLocation
from followspot.transport.ring.notification import (
    INLINE,
    INLINE_BYTES,
    MAX_SLOTS,
    MESSAGE,
    NOTIFICATION,
    OVER,
    SLOT,
    WATERMARK,
)
from followspot.transport.ring.slots import Slots
from followspot.transport.token import END, UNKNOWN, Watermark
from followspot.transport.wire import ALIGN, padded


class RingWriter:
    """`PortWriter` for readers on this host.

    Every reader, and this process with its loans, may keep `depth + 1` slots for any time; two more keep the
    stream going. Slots that were never used take no memory.
    """

    def __init__(
        self, sockets: Sequence[socket.socket], depth: int, locations: Sequence[ReaderLocation] = ()
    ) -> None:
        """sockets: one end of a `socketpair(AF_UNIX, SOCK_SEQPACKET)` per reader; depth: messages in flight.

        locations: of all readers, so that those of one worker share datagrams; () if none does.
        Raises OSError if the system has no shared memory left.
        """
        self._depth = depth
        self._quota = depth + 1
        self._slots = min(self._quota * (len(sockets) + 1) + 2, MAX_SLOTS)
        self._sequence = 0
        self._granted = 0
        self._over = False
        self._pool: Slots | None = None
        self._heads: HeadPacker | None = None
        self._links = ReaderLinks(sockets, depth, self._quota, self._slots)
        if locations:
            self._links.share(locations)

    @property
    def lost(self) -> frozenset[int]:
        """Indices of the readers that `drain` found gone before the end."""
        return self._links.lost

    def newly_dead(self) -> list[tuple[int, int]]:
        """Readers that `drain` or `replace` found dead since the last call; see `PortWriter.newly_dead`."""
        return self._links.newly_dead()

    @property
    def rejected(self) -> int:
        """Number of readers that the writer cut off because they broke the protocol."""
        return self._links.expelled

    def matched(self) -> bool:
        """True: the sockets exist before the processes do."""
        return True

    def replace(self, index: int, sock: socket.socket) -> None:
        """Serve another reader, from the next message on, in place of one that is gone."""
        link = self._links.replace(index, sock, self._sequence, self._pool)
        if self._over:
            link.send(OVER)

    @property
    def all_taken(self) -> bool:
        """True: readers see in shared memory whether they have caught up."""
        return True

    def dismiss(self, index: int) -> None:
        """See `PortWriter.dismiss`."""
        self._links.dismiss(index, self._pool)

    def credit(self) -> int:
        """How many messages may be sent now."""
        links, credit = self._links, self._depth
        slowest = self._sequence
        for control in links.controls:
            consumed = control.words[CONSUMED]
            if consumed > self._sequence:
                links.expel_overclaiming(self._sequence)
            elif consumed < slowest:
                slowest = consumed
        credit += slowest - self._sequence
        if credit > 0 and links.controls and self._pool is not None:
            free = self._pool.find_free(links.holding)
            if free < credit:
                credit = free
        self._granted = credit
        return credit if credit > 0 else 0

    def send(self, token: Message | Watermark, watermark: int = UNKNOWN) -> None:
        """Notify all readers; see `PortWriter.send`."""
        if isinstance(token, Watermark):
            self._over |= token.time == END
            self._links.send(NOTIFICATION.pack(WATERMARK, 0, 0, 0, token.time))
            return
        if not self._links.living:
            return
        if self._granted <= 0 and not self.credit():
            raise RuntimeError("a message was sent without credit")
        values = token.__dict__
        arrays = []
        for name in token.array_names:
            arrays.append(values[name])  # noqa: PERF401  # a comprehension is a call more
        heads = self._heads
        if heads is None or heads.kind is not type(token):
            heads = self._heads = HeadPacker(type(token))
        head, size = heads.pack(token, arrays)
        if size <= INLINE_BYTES:
            datagram = self._inline((*token.header[1:], watermark), head, arrays, size)
        else:
            told, places = self._placed((*token.header[1:], watermark), arrays, size)
            datagram = told + head + heads.places.pack(*places)
        self._sequence += 1
        self._granted -= 1
        self._links.send(datagram)

    def loan(self, shape: Sequence[int], dtype: str) -> Array | None:
        """A writable array in a free slot; None if no slot can be spared, or the array is small."""
        kind = np.dtype(dtype)
        size = prod(shape) * kind.itemsize
        if not self._links.living or not INLINE_BYTES < size <= MAX_BYTES:
            return None
        pool = self._pool_for(size)
        left = pool.find_free(self._links.holding) - 1
        if left < 2 or pool.lent >= self._quota:
            return None
        if left < self._granted:
            self._granted = left
        return pool.lend(shape, kind)

    def flush(self) -> bool:
        """Send the datagrams that wait for a socket. True when none waits."""
        waiting = [link for link in self._links.all if not link.flush()]
        return not waiting

    def filenos(self) -> list[int]:
        """The sockets of the living readers."""
        return [link.socket.fileno() for link in self._links.living]

    def want_credit(self) -> None:
        """Ask every reader for a wake-up."""
        for link in self._links.all:
            link.ask()

    def drain(self) -> None:
        """Clear wake-ups, notice deaths, send the waiting datagrams."""
        self._links.drain(self._sequence)
        self.flush()

    def close(self) -> None:
        """Close the sockets; readers find the end of file after the last datagram."""
        self._links.close()

    def _pool_for(self, size: int) -> Slots:
        """The slots, or new ones of `size` bytes; the old ones live on while an array views them."""
        pool = self._pool
        if pool is None or pool.arena.capacity < size:
            pool = self._pool = Slots(0 if pool is None else pool.arena.number + 1, self._slots, size)
            self._links.announce(pool)
        return pool

    def _inline(self, numbers: Sequence[int], head: bytes, arrays: Sequence[Array], size: int) -> bytes:
        """The datagram that brings the arrays."""
        parts = [MESSAGE.pack(INLINE, 0, 0, size, self._sequence, *numbers), head]
        for array in arrays:
            parts += array.tobytes(), bytes(-array.nbytes % ALIGN)
        return b"".join(parts)

    def _placed(self, numbers: Sequence[int], arrays: Sequence[Array], size: int) -> tuple[bytes, list[int]]:
        """Copy the arrays into a slot, except one that is there already; which slot, and where in it."""
        pool = self._pool_for(size)
        stamp = self._sequence + 1
        kept, slot, end = pool.in_place(arrays, size, stamp) or (-1, pool.take(), 0)
        places = []
        for index, array in enumerate(arrays):
            if index == kept:
                places.append(0)
                continue
            places.append(end)
            pool.arena.array(slot, array.shape, array.dtype, end)[...] = array
            end += padded(array.nbytes)
        pool.stamps[slot] = stamp
        if self._links.dismissed:
            self._links.pass_over(pool.arena.number, slot, stamp)
        return MESSAGE.pack(SLOT, pool.arena.number, slot, end, self._sequence, *numbers), places
