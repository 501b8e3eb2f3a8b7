"""Ranges of the numbers that other processes, files and hosts tell, for whoever checks them on the way in.

A Python integer knows no end, but what it goes into does: 64-bit words, arrays, waits, JSON that a browser
reads. Pydantic checks these where it validates data whose types they are.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from followspot.messages import MAX_TIME

MAX_EXACT = 1 << 53
"""Largest whole number that every reader of JSON keeps exact; a thousand of them fit into 64 bits."""
MAX_WAIT = 3600.0
"""Longest time, s, that a graph may have anything wait."""

Count = Annotated[int, Field(ge=0, le=MAX_EXACT)]
"""How many there are of something."""
Last = Annotated[int, Field(ge=-1, le=MAX_EXACT)]
"""Number of the newest of something, -1 where there is none."""
Incarnation = Annotated[int, Field(ge=0, le=100_000_000)]
"""How often a worker was started before."""
Nanoseconds = Annotated[int, Field(ge=-MAX_TIME, le=MAX_TIME)]
"""A moment, or the difference of two."""
Figure = Annotated[float, Field(ge=-1e18, le=1e18)]
"""A figure to be shown: finite, and of a length that fits on a page."""
Age = Annotated[float, Field(ge=0.0, le=1e12, allow_inf_nan=False)]
"""Seconds since something was last heard or seen, by the monotonic clock of whoever listened."""
Wait = Annotated[float, Field(ge=0.0, le=MAX_WAIT)]
"""A time, s, that something may have to wait."""
