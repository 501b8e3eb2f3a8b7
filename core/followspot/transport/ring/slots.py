"""Slots of shared memory, one message in each, and leases that keep a slot while an array views it."""

from __future__ import annotations

import mmap
from collections.abc import Callable, Sequence
from typing import Any
from weakref import ref

import numpy as np

from followspot.messages import Array
from followspot.transport.ring.control import Control, released_word
from followspot.transport.ring.memory import Memory
from followspot.transport.wire import padded


class Arena:
    """Equal slots, page-aligned, in one piece of memory."""

    def __init__(self, memory: Memory, number: int, slots: int, capacity: int) -> None:
        """number: of the arena within the ring; capacity: of a slot, bytes, in whole pages."""
        self.memory = memory
        self.number = number
        self.slots = slots
        self.capacity = capacity

    def array(self, slot: int, shape: Sequence[int], dtype: np.dtype[Any], start: int = 0) -> Array:
        """An array at byte `start` of a slot, writable if the memory is."""
        return np.ndarray(shape, dtype, self.memory.bytes, slot * self.capacity + start)

    def has(self, number: int, slot: int, size: int) -> bool:
        """True if this arena has the number, and a slot of this index with at least `size` bytes."""
        return number == self.number and slot < self.slots and size <= self.capacity


class Lease(ref[Array]):
    """Knows in which slot an array lies, and tells when it has died.

    The array lives as long as any view of it. The lender must keep the lease, for one that has been
    collected tells nothing.
    """

    __slots__ = ("key", "slot", "stamp")
    __hash__ = object.__hash__
    __eq__ = object.__eq__

    key: int
    """The key under which the lender keeps the lease."""
    slot: int
    stamp: int
    """Stamp of the message in the slot, 0 while none was sent from it."""


LEASES: set[Lease] = set()
"""The leases of all readers of this process: a reader that has left the graph still releases slots later."""


def lease(array: Array, key: int, slot: int, stamp: int, ended: Callable[[Any], None]) -> Lease:
    """A lease that calls `ended` with itself when the array has died."""
    made = Lease(array, ended)
    made.key = key
    made.slot = slot
    made.stamp = stamp
    return made


class Slots:
    """The writer's view of an arena: which slots are free, and which are lent to this process.

    A slot is free when no view of it lives here and every reader has released the last message sent from it.
    Few slots are in use at once, so plain numbers serve better than arrays: numpy's code would be cold.
    """

    def __init__(self, number: int, slots: int, smallest: int) -> None:
        """number: of the arena; smallest: capacity that a slot needs, bytes. Raises OSError."""
        capacity = max(mmap.PAGESIZE, 1 << (smallest - 1).bit_length())
        self.arena = Arena(Memory.create("followspot-slots", slots * capacity), number, slots, capacity)
        self.stamps = [0] * slots
        """Stamp of the last message sent from each slot."""
        self._free = list(range(slots - 1, -1, -1))
        """Free slots; those released last are at the end."""
        self._leases: dict[int, Lease] = {}
        """Leases of arrays that this process views, by the identity of the array while it lives."""
        self._sizes = [0] * slots
        """Bytes that are lent of each slot, with their padding, 0 if it is not lent."""
        self._used: list[int] = []
        self._released = released_word(number, slots)

    @property
    def lent(self) -> int:
        """Number of slots that arrays of this process view."""
        return len(self._leases)

    def find_free(self, controls: Sequence[Control]) -> int:
        """Find the slots that may be written; how many. A reader cannot take a slot back later."""
        used: list[int] = []
        for slot in self._used:
            kept = self._sizes[slot] > 0
            for control in controls:
                kept = kept or control.words[self._released + slot] != self.stamps[slot]
            (used if kept else self._free).append(slot)
        self._used = used
        return len(self._free)

    def lend(self, shape: Sequence[int], dtype: np.dtype[Any]) -> Array:
        """A writable array at the start of a free slot, which is kept until the array dies."""
        slot = self.take()
        loan = self.arena.array(slot, shape, dtype)
        self._sizes[slot] = padded(loan.nbytes)
        key = id(loan)
        self._leases[key] = lease(loan, key, slot, 0, self._end)
        return loan

    def take(self) -> int:
        """Take the free slot that was used last: it is still in the processor's cache."""
        slot = self._free.pop()
        self._used.append(slot)
        return slot

    def in_place(self, arrays: Sequence[Array], size: int, stamp: int) -> tuple[int, int, int] | None:
        """Find an array that was lent and not sent yet, and stamp its lease.

        size: of all arrays, bytes. Returns its index, its slot, and the byte at which the others may begin:
        behind all that was lent, for they may be views of that. None if there is no such array, or no space.
        """
        for index, array in enumerate(arrays):
            found = self._leases.get(id(array)) or self._leases.get(id(array.base))
            if found is None or found.stamp:
                continue
            end = self._sizes[found.slot]
            if end + size - padded(array.nbytes) > self.arena.capacity:
                continue
            loan = found()
            if loan is array or (loan is not None and array.ctypes.data == loan.ctypes.data):
                found.stamp = stamp
                return index, found.slot, end
        return None

    def _end(self, ended: Lease) -> None:
        del self._leases[ended.key]
        self._sizes[ended.slot] = 0
