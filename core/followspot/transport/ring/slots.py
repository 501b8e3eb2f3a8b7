"""Slots of shared memory, one message in each, and leases that keep a slot while an array views it."""

from __future__ import annotations

import mmap
from collections.abc import Callable, Iterable, Sequence
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
    """

    def __init__(self, number: int, slots: int, smallest: int) -> None:
        """number: of the arena; smallest: capacity that a slot needs, bytes. Raises OSError."""
        capacity = max(mmap.PAGESIZE, 1 << (smallest - 1).bit_length())
        self.arena = Arena(Memory.create("followspot-slots", slots * capacity), number, slots, capacity)
        self.stamps: Array = np.zeros(slots, np.uint64)
        self._lent: Array = np.zeros(slots, bool)
        self._free: Array = np.ones(slots, bool)
        self._sizes = [0] * slots

    def find_free(self, controls: Iterable[Control]) -> int:
        """Find the slots that may be written; how many. A reader cannot take a slot back later."""
        free = ~self._lent
        for control in controls:
            free &= control.released(self.arena.number) == self.stamps
        self._free = free
        return int(np.count_nonzero(free))

    def lent(self) -> int:
        """Number of slots that arrays of this process view."""
        return int(np.count_nonzero(self._lent))

    def lend(self, shape: Sequence[int], dtype: np.dtype[Any]) -> Array:
        """A writable array at the start of a free slot, which is kept until the array dies."""
        slot = self.first_free()
        interface = self.arena.interface(slot, shape, dtype.str, writable=True)
        loan = np.asarray(Lease(self.arena, slot, 0, interface, self._end))
        self._lent[slot] = True
        self._free[slot] = False
        self._sizes[slot] = loan.nbytes
        return loan

    def first_free(self) -> int:
        """The first free slot: slots used lately are still in the processor's cache."""
        return int(self._free.argmax())

    def fill(self, slot: int, stamp: int) -> None:
        """Note that the slot holds the message of this stamp."""
        self.stamps[slot] = stamp
        self._free[slot] = False

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
        self._lent[lease.slot] = False
