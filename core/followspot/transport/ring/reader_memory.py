"""The memory of a ring as one reader has it mapped: its words, the slots, and the leases of its messages."""

from __future__ import annotations

import contextlib
import mmap
import os
import socket
from collections.abc import Sequence

import numpy as np

from followspot.errors import FollowspotError
from followspot.messages import Array, InvalidMessage
from followspot.operating_system.limits import limit_remedy
from followspot.transport.ring.control import ARENAS, WAITING, Control, fence, released_word
from followspot.transport.ring.heads import Head, HeadReader
from followspot.transport.ring.memory import Memory
from followspot.transport.ring.notification import ARENA, HELLO, MAX_SLOT, MAX_SLOTS
from followspot.transport.ring.slots import LEASES, Arena, Lease, lease
from followspot.transport.token import MAX_COUNT
from followspot.transport.wire import aligned

_BYTES = np.dtype(np.uint8)


def unmapped(error: OSError) -> FollowspotError:
    """The error of a reader that cannot map memory which its writer sent."""
    remedy = limit_remedy(error, "take fewer workers: --placement")
    return FollowspotError(f"the memory of an edge cannot be mapped: {error.strerror}\n    {remedy}")


class ReaderMemory:
    """Maps what the writer sends, and gives arrays that are views of a slot, each for as long as it lives.

    heads, sock: of the reader.
    """

    def __init__(self, heads: HeadReader, sock: socket.socket) -> None:
        self.control: Control | None = None
        self._heads = heads
        self._socket = sock
        self._arena: Arena | None = None
        self._slots = 0
        self._quota = 0
        self._leases: set[Lease] = set()

    def has(self, number: int, slot: int, size: int) -> bool:
        """Whether there is this slot of this arena, and so many bytes in it."""
        return self._arena is not None and self._arena.has(number, slot, size)

    def arrays(
        self, head: Head, starts: Sequence[int], number: int, slot: int, size: int, stamp: int
    ) -> list[Array]:
        """Arrays in a slot, leased; in a copy if this reader has its share of leases.

        starts: the byte of the slot at which each begins; number, size: of the arena, and bytes in the slot;
        stamp: of the message, its sequence number + 1. Raises InvalidMessage if there is no such slot.
        """
        arena = self._arena
        if arena is None or not arena.has(number, slot, size):
            raise InvalidMessage(f"{size} bytes in slot {slot} of arena {number}, which does not exist")
        word = released_word(number, self._slots) + slot
        if len(self._leases) >= self._quota:
            body = aligned(size)
            body[:] = arena.array(slot, (size,), _BYTES)
            self._release(word, stamp)
            body.flags.writeable = False
            return self._heads.views(head, starts, body)
        if len(starts) == 1:  # it is the array that keeps the slot
            body = arena.array(slot, head.shapes[0], self._heads.dtypes[0], starts[0])
            arrays = [body]
        else:
            body = arena.array(slot, (size,), _BYTES)
            arrays = self._heads.views(head, starts, body)
        made = lease(body, word, slot, stamp, self._end_lease)
        self._leases.add(made)
        LEASES.add(made)
        return arrays

    def release(self, number: int, slot: int, stamp: int) -> None:
        """Release the message in a slot that exists."""
        self._release(released_word(number, self._slots) + slot, stamp)

    def map(self, fd: int, kind: int, number: int, slot: int, size: int, value: int) -> bool:
        """Map the memory that a datagram brought, `HELLO` or `ARENA`; False if it is not what it claims.

        fd: of the memory, which belongs to this from now on. Raises FollowspotError if it cannot be mapped.
        """
        if not self._credible(kind, number, slot, size, value):
            os.close(fd)
            return False
        try:
            if kind == HELLO:
                self.control = Control(Memory(fd, Control.size(size), writable=True), size)
                self._quota, self._slots = slot, size
            else:
                memory = Memory(fd, self._slots * value, writable=False)
                self._arena = Arena(memory, number, self._slots, value)
        except ValueError:
            return False
        except OSError as error:
            raise unmapped(error) from None
        return True

    def wake(self, control: Control) -> None:
        """Wake the writer, which asked for that."""
        control.words[WAITING] = 0
        with contextlib.suppress(OSError):  # a full socket wakes the writer anyway, a closed one has none
            self._socket.send(b"\1")

    def _end_lease(self, ended: Lease) -> None:
        """Release the slot of an array that died."""
        self._leases.discard(ended)
        LEASES.discard(ended)
        self._release(ended.key, ended.stamp)

    def _release(self, word: int, stamp: int) -> None:
        """Release the message in a slot."""
        control = self.control
        if control is not None:
            control.words[word] = stamp
            fence()
            if control.words[WAITING]:
                self.wake(control)

    def _credible(self, kind: int, number: int, slot: int, size: int, value: int) -> bool:
        """Whether a writer sends this: one HELLO, and arenas each newer than the one before."""
        if kind == HELLO:
            return self.control is None and slot <= size and 0 < size <= MAX_SLOTS and 0 <= value <= MAX_COUNT
        newest = -1 if self._arena is None else self._arena.number
        whole = 0 < value <= MAX_SLOT and value % mmap.PAGESIZE == 0
        return kind == ARENA and self.control is not None and newest < number < ARENAS and whole
