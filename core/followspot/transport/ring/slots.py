"""Slots of shared memory, one message in each, and leases that keep a slot while an array views it."""

from __future__ import annotations

import mmap
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.transport.ring.control import Control
from followspot.transport.ring.memory import Memory
from followspot.transport.wire import padded


class Arena:
    """Equal slots, page-aligned, in one piece of memory."""

    def __init__(self, memory: Memory, number: int, slots: int, capacity: int) -> None:
        """number: of the arena within the ring; capacity: of a slot, bytes, in whole pages."""
        self.memory = memory
        self.number = number
        self.capacity = capacity
        self.bytes: Array = np.frombuffer(memory.bytes, np.uint8).reshape(slots, capacity)
        start = self.bytes.ctypes.data
        self.addresses = range(start, start + slots * capacity, capacity)
        """Address of each slot in this process."""

    def interface(self, slot: int, shape: Sequence[int], dtype: str, *, writable: bool) -> dict[str, Any]:
        """The start of a slot as an array, in terms of numpy's array interface."""
        data = self.addresses[slot], not writable
        return {"version": 3, "data": data, "shape": tuple(shape), "typestr": dtype}


class Lease:
    """Lends the start of a slot to numpy; it calls `end` with itself when the last view of it dies.

    stamp: of the message in the slot, 0 while none was sent from it.
    """

    __slots__ = ("__array_interface__", "_end", "arena", "slot", "stamp")

    def __init__(
        self, arena: Arena, slot: int, stamp: int, interface: dict[str, Any], end: Callable[[Lease], None]
    ) -> None:
        self.__array_interface__ = interface
        self.arena = arena
        self.slot = slot
        self.stamp = stamp
        self._end = end

    def __del__(self) -> None:
        self._end(self)


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
        """Of the last message sent from each slot."""
        self.lent = 0
        """Number of slots that arrays of this process view."""
        self._sizes = [0] * slots
        """Bytes that are lent of each slot, 0 if it is not lent."""
        self._free = list(range(slots - 1, -1, -1))
        """Those released last are at the end."""
        self._used: list[int] = []

    def find_free(self, controls: Sequence[Control]) -> int:
        """Find the slots that may be written; how many. A reader cannot take a slot back later."""
        number, stamps, sizes = self.arena.number, self.stamps, self._sizes
        used = []
        for slot in self._used:
            stamp = stamps[slot]
            if sizes[slot] or any(c.released(number, slot) != stamp for c in controls):
                used.append(slot)
            else:
                self._free.append(slot)
        self._used = used
        return len(self._free)

    def lend(self, shape: Sequence[int], dtype: np.dtype[Any]) -> Array:
        """A writable array at the start of a free slot, which is kept until the array dies."""
        slot = self.take()
        interface = self.arena.interface(slot, shape, dtype.str, writable=True)
        loan = np.asarray(Lease(self.arena, slot, 0, interface, self._end))
        self.lent += 1
        self._sizes[slot] = loan.nbytes
        return loan

    def take(self) -> int:
        """Take a free slot, one that was used lately, for it is still in the processor's cache."""
        slot = self._free.pop()
        self._used.append(slot)
        return slot

    def in_place(self, arrays: Sequence[Array], size: int, stamp: int) -> tuple[int, int, int] | None:
        """Find an array that was lent and not sent yet, and stamp its lease.

        size: of all arrays, bytes. Returns its index, its slot, and the byte at which the others may begin:
        behind all that was lent, for they may be views of that. None if there is no such array, or no space.
        """
        for index, array in enumerate(arrays):
            owner: Any = array.base
            viewed = type(owner) is np.ndarray
            lease = owner.base if viewed else owner
            if type(lease) is not Lease or lease.arena is not self.arena or lease.stamp:
                continue
            end = padded(self._sizes[lease.slot])
            if end + size - padded(array.nbytes) > self.arena.capacity:
                continue
            if not viewed or array.ctypes.data == self.arena.addresses[lease.slot]:
                lease.stamp = stamp
                return index, lease.slot, end
        return None

    def _end(self, lease: Lease) -> None:
        self._sizes[lease.slot] = 0
        self.lent -= 1
