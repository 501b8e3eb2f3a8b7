"""The writing end of the ring: it writes a frame into shared memory once, for all readers of a port."""

from __future__ import annotations

import socket
from collections.abc import Sequence
from math import prod

import numpy as np

from followspot.messages import MAX_BYTES, Array, Message
from followspot.transport.codec import Codec, codec_of
from followspot.transport.ring.control import Control
from followspot.transport.ring.memory import Memory
from followspot.transport.ring.notification import (
    ARENA,
    HELLO,
    INLINE,
    INLINE_BYTES,
    MAX_SLOTS,
    NOTIFICATION,
    OVER,
    SLOT,
    WATERMARK,
    Link,
)
from followspot.transport.ring.slots import Slots
from followspot.transport.token import END, Watermark
from followspot.transport.wire import ALIGN, padded


class RingWriter:
    """`PortWriter` for readers on this host.

    Every reader, and this process with its loans, may keep `depth + 1` slots for any time; two more keep the
    stream going. Slots that were never used take no memory.
    """

    def __init__(self, sockets: Sequence[socket.socket], depth: int) -> None:
        """sockets: one end of a `socketpair(AF_UNIX, SOCK_SEQPACKET)` per reader; depth: messages in flight.

        Raises OSError if the system has no shared memory left.
        """
        self._depth = depth
        self._quota = depth + 1
        self._slots = min(self._quota * (len(sockets) + 1) + 2, MAX_SLOTS)
        self._sequence = 0
        self._granted = 0
        self._over = False
        self._expelled = 0
        self._perished: list[tuple[int, int]] = []
        self._pool: Slots | None = None
        self._links = [self._linked(sock) for sock in sockets]

    @property
    def lost(self) -> frozenset[int]:
        """Indices of the readers that `drain` found gone before the end."""
        return frozenset(i for i, link in enumerate(self._links) if not link.alive and not link.ended)

    def perished(self) -> list[tuple[int, int]]:
        """Readers that `drain` or `replace` found dead since the last call; see `PortWriter.perished`."""
        perished, self._perished = self._perished, []
        return perished

    @property
    def strangers(self) -> int:
        """Readers that the writer cut off because they did what no reader does."""
        return self._expelled + sum(link.expelled for link in self._links)

    def matched(self) -> bool:
        """True: the sockets exist before the processes do."""
        return True

    def replace(self, index: int, sock: socket.socket) -> None:
        """Serve another reader, from the next message on, in place of one that is gone."""
        self._expelled += self._links[index].expelled
        if self._links[index].alive:
            self._note_death(index)
        self._links[index].socket.close()
        self._links[index] = self._linked(sock)
        if self._over:
            self._links[index].send(OVER)

    def credit(self) -> int:
        """How many messages may be sent now."""
        controls = self._controls()
        credit = self._depth
        if controls:
            consumed = [control.consumed for control in controls]
            if max(consumed) > self._sequence:
                self._expel()
            slowest = min(consumed)
            credit = min(credit, max(0, credit - self._sequence + slowest))
            if credit and self._pool is not None:
                credit = min(credit, self._pool.find_free(controls))
        self._granted = credit
        return credit

    def send(self, token: Message | Watermark) -> None:
        """Notify all readers; see `PortWriter.send`."""
        if isinstance(token, Watermark):
            self._over |= token.time == END
            self._send_all(NOTIFICATION.pack(WATERMARK, 0, 0, 0, token.time))
            return
        if not self._controls():
            return
        if self._granted <= 0 and not self.credit():
            raise RuntimeError("a message was sent without credit")
        codec = codec_of(type(token))
        arrays = codec.arrays(token)
        head = codec.head(token, arrays)
        size = sum([padded(array.nbytes) for array in arrays])
        if size <= INLINE_BYTES:
            parts = [NOTIFICATION.pack(INLINE, 0, 0, size, self._sequence), head]
            for array in arrays:
                parts += array.tobytes(), bytes(-array.nbytes % ALIGN)
            datagram = b"".join(parts)
        else:
            datagram = self._placed(codec, head, arrays, size)
        self._sequence += 1
        self._granted -= 1
        self._send_all(datagram)

    def loan(self, shape: Sequence[int], dtype: str) -> Array | None:
        """A writable array in a free slot; None if no slot can be spared, or the array is small."""
        kind = np.dtype(dtype)
        size = prod(shape) * kind.itemsize
        controls = self._controls()
        if controls and INLINE_BYTES < size <= MAX_BYTES:
            pool = self._pool_for(size)
            left = pool.find_free(controls) - 1
            if left >= 2 and pool.lent < self._quota:
                self._granted = min(self._granted, left)
                return pool.lend(shape, kind)
        return None

    def flush(self) -> bool:
        """Send what waits for a socket. True when nothing waits."""
        waiting = [link for link in self._links if not link.flush()]
        return not waiting

    def filenos(self) -> list[int]:
        """The sockets of the living readers."""
        return [link.socket.fileno() for link in self._links if link.alive]

    def want_credit(self) -> None:
        """Ask every reader for a wake-up."""
        for link in self._links:
            link.ask()

    def drain(self) -> None:
        """Clear wake-ups, notice deaths, send what waited."""
        for index, link in enumerate(self._links):
            was_alive = link.alive
            if was_alive:
                link.drain()
            if was_alive and not link.alive:
                self._note_death(index)
        self.flush()

    def close(self) -> None:
        """Close the sockets; readers find the end of file after the last datagram."""
        for link in self._links:
            link.alive = False
            link.socket.close()

    def _note_death(self, index: int) -> None:
        """Count the messages for which a dead reader has given no credit."""
        self._perished.append((index, max(0, self._sequence - self._links[index].control.consumed)))

    def _linked(self, sock: socket.socket) -> Link:
        """The link to a new reader, for which everything so far is consumed and released."""
        control = Control(Memory.create("followspot-control", Control.size(self._slots)), self._slots)
        control.consumed = self._sequence
        link = Link(sock, control, self._depth)
        link.send(NOTIFICATION.pack(HELLO, 0, self._quota, self._slots, self._sequence), control.memory)
        if self._pool is not None:
            control.release_all(self._pool.arena.number, self._pool.stamps)
            link.send(_announced(self._pool), self._pool.arena.memory)
        return link

    def _expel(self) -> None:
        """Cut off readers that claim to have consumed more than was sent."""
        for link in self._links:
            if link.alive and link.control.consumed > self._sequence:
                link.expel()

    def _controls(self) -> list[Control]:
        return [link.control for link in self._links if link.alive]

    def _send_all(self, datagram: bytes) -> None:
        for link in self._links:
            if link.alive:
                link.send(datagram)

    def _pool_for(self, size: int) -> Slots:
        """The slots, or larger ones; old ones live on while an array views them."""
        pool = self._pool
        if pool is None or pool.arena.capacity < size:
            pool = self._pool = Slots(0 if pool is None else pool.arena.number + 1, self._slots, size)
            for link in self._links:
                if link.alive:
                    link.send(_announced(pool), pool.arena.memory)
        return pool

    def _placed(self, codec: Codec, head: bytes, arrays: Sequence[Array], size: int) -> bytes:
        """Copy the arrays into a slot, except one that is there already; the datagram that tells where."""
        pool = self._pool_for(size)
        stamp = self._sequence + 1
        kept, slot, end = pool.in_place(arrays, size, stamp) or (-1, pool.take(), 0)
        places = []
        for index, array in enumerate(arrays):
            if index == kept:
                places.append(0)
                continue
            places.append(end)
            pool.arena.bytes[slot, end : end + array.nbytes] = array.reshape(-1).view(np.uint8)
            end += padded(array.nbytes)
        pool.stamps[slot] = stamp
        notification = NOTIFICATION.pack(SLOT, pool.arena.number, slot, end, self._sequence)
        return notification + head + codec.places.pack(*places)


def _announced(pool: Slots) -> bytes:
    return NOTIFICATION.pack(ARENA, pool.arena.number, 0, 0, pool.arena.capacity)
