"""The datagrams that notify readers of a ring.

Datagram: `NOTIFICATION` (kind, arena, slot, size, value), and for a message `MESSAGE`, which begins with the
same and goes on with frame number, capture time, entry, and the watermark after it (`UNKNOWN`: it comes by
itself); then the packed head of `ring.heads`, then the arrays (INLINE) or the byte of the slot at which each
begins (SLOT).
"""

from __future__ import annotations

from struct import Struct

from followspot.messages import MAX_BYTES
from followspot.transport.token import END

NOTIFICATION = Struct("<BBHIq")
MESSAGE = Struct(NOTIFICATION.format + "qqqq")
HELLO, ARENA, INLINE, SLOT, WATERMARK, CARRIES, CARRIED = range(1, 8)
"""HELLO: slot = most leases, size = number of slots, value = first sequence number; with the control memory.
ARENA: value = capacity of a slot, bytes; with the memory of the slots. INLINE, SLOT: value = sequence number,
size = bytes of arrays. WATERMARK: value = its time, ns. CARRIES: value = number of another edge from the port
to this process, whose reader gets all messages and watermarks that follow, too. CARRIED: value = number of
the edge by which those of this reader come."""
OVER = NOTIFICATION.pack(WATERMARK, 0, 0, 0, END)
MAX_SLOTS = 1 << 16
"""Most slots of an arena: as many as a datagram can number."""
MAX_SLOT = 2 * MAX_BYTES
"""Largest slot, bytes: the arrays with their padding, rounded up to a power of two."""
INLINE_BYTES = 4096
"""Most bytes of arrays that travel in the datagram."""
