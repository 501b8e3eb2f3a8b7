"""Ranges of numbers from other processes, files and hosts, as types for pydantic.

A Python integer has no limit, but 64-bit words, arrays, waits and the JSON of a browser have. Pydantic checks
these types when it validates data.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from followspot.messages import MAX_TIME

MAX_EXACT = 1 << 53
"""Largest whole number that every reader of JSON keeps exact; a thousand of them fit into 64 bits."""
MAX_WAIT = 3600.0
"""Longest wait that a graph may ask for, s."""

Count = Annotated[int, Field(ge=0, le=MAX_EXACT)]
"""A number of things."""
Last = Annotated[int, Field(ge=-1, le=MAX_EXACT)]
"""Number of the newest item, -1 if there is none."""
Incarnation = Annotated[int, Field(ge=0, le=100_000_000)]
"""Number of earlier starts of a worker."""
Nanoseconds = Annotated[int, Field(ge=-MAX_TIME, le=MAX_TIME)]
"""A time, or the difference of two, ns."""
Figure = Annotated[float, Field(ge=-1e18, le=1e18)]
"""A figure for display: finite, with a limited number of digits."""
Age = Annotated[float, Field(ge=0.0, le=1e12, allow_inf_nan=False)]
"""Seconds since the last sign of something, by the monotonic clock of the observer."""
Wait = Annotated[float, Field(ge=0.0, le=MAX_WAIT)]
"""A wait, s."""
