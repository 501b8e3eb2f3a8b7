"""Slots of shared memory, one message in each, and leases that keep a slot while somebody looks at it."""

from __future__ import annotations

import mmap
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.transport.control import Control
from followspot.transport.memory import Memory


class Arena:
    """Equal slots, page-aligned, in one piece of memory."""

    def __init__(self, memory: Memory, slots: int, capacity: int) -> None:
        """capacity: of a slot, bytes; a multiple of the page size."""
        self.memory = memory
        self.slots = slots
        self.capacity = capacity
        self.bytes: Array = np.frombuffer(memory.bytes, np.uint8).reshape(slots, capacity)
        self._address = self.bytes.ctypes.data

    def address(self, slot: int) -> int:
        """Where the slot begins in this process."""
        return self._address + slot * self.capacity


class Lease:
    """Lends the start of a slot to numpy; when the last view of it is gone, `release` is called."""

    __slots__ = ("__array_interface__", "_arena", "_release")

    def __init__(
        self,
        arena: Arena,
        slot: int,
        shape: Sequence[int],
        dtype: str,
        release: Callable[[], object],
        *,
        writable: bool,
    ) -> None:
        self.__array_interface__: dict[str, Any] = {
            "version": 3,
            "data": (arena.address(slot), not writable),
            "shape": tuple(shape),
            "typestr": dtype,
        }
        self._arena = arena  # the memory stays mapped
        self._release = release

    def __del__(self) -> None:
        self._release()


class Slots:
    """The writer's view of an arena: which slots are free, and which are lent to this process.

    A slot is free when no view of it lives here and every reader has released the last message sent from it.
    """

    def __init__(self, number: int, slots: int, smallest: int) -> None:
        """number: of the arena in the ring's life; smallest: capacity needed, bytes. Raises OSError."""
        capacity = max(mmap.PAGESIZE, 1 << (smallest - 1).bit_length())
        self.number = number
        self.arena = Arena(Memory.create("followspot-slots", slots * capacity), slots, capacity)
        self.stamps: Array = np.zeros(slots, np.uint64)
        self._lent: Array = np.zeros(slots, bool)
        self._loans: dict[int, tuple[int, int]] = {}

    def free(self, controls: Iterable[Control]) -> Array:
        """(slots,) bool: the slots that may be written."""
        free = ~self._lent
        for control in controls:
            free &= control.released(self.number) == self.stamps
        return free

    def lent(self) -> int:
        """Number of slots that this process looks at."""
        return int(self._lent.sum())

    def lend(self, slot: int, shape: Sequence[int], dtype: np.dtype[Any], size: int) -> Array:
        """A writable array of `size` bytes at the start of a free slot, kept until the array dies."""
        address = self.arena.address(slot)
        self._lent[slot] = True
        self._loans[address] = slot, size
        end = partial(self._end, slot, address)
        return np.asarray(Lease(self.arena, slot, shape, dtype.str, end, writable=True))

    def in_place(self, arrays: Sequence[Array]) -> tuple[int, int, int] | None:
        """Index of an array that was lent and not sent yet, its slot, and the bytes that were lent."""
        if self._loans:
            for index, array in enumerate(arrays):
                loan = self._loans.get(array.ctypes.data)
                if loan is not None:
                    return index, *loan
        return None

    def sent(self, slot: int, stamp: int) -> None:
        """The message of this stamp went out from the slot; a loan of it cannot go out in place again."""
        self.stamps[slot] = stamp
        self._loans.pop(self.arena.address(slot), None)

    def _end(self, slot: int, address: int) -> None:
        self._loans.pop(address, None)
        self._lent[slot] = False
