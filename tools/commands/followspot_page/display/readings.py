"""Readings of sensors in the page's form: lines of inertial sensors, a table of all others."""

from __future__ import annotations

from typing import Any

import numpy as np

from followspot.frame_times import to_seconds
from followspot.inertial import Inertial
from followspot.message_table import rows_of, table_of
from followspot.messages import Message
from followspot.room import Room

MOST_POINTS = 16
"""Readings of one message that are drawn; of more, as many at equal steps, the last among them."""
MOST_ROWS, MOST_COLUMNS, LONGEST = 6, 12, 40
"""Rows, columns and characters of a value that a table shows."""
_DIGITS = 4
_TELLING = 3
"""Readings that tell a rate."""


def inertial_view(m: Inertial, room: Room) -> dict[str, Any]:
    """Times in ms, turn rates in rad/s and specific forces in m/s^2 of at most `MOST_POINTS` readings.

    rate: of all readings of the message, 1/s; None if they are too few to tell.
    """
    count = len(m.time)
    span = to_seconds(m.time[-1] - m.time[0]) if count >= _TELLING else 0.0
    drawn = np.unique(np.linspace(count - 1, 0, min(count, MOST_POINTS)).astype(int))
    return {
        "readings": count,
        "rate": round((count - 1) / span, 3) if span > 0 else None,
        "times": (m.time[drawn] / 1e6).round(3).tolist(),
        "turn_rate": _known(m.turn_rate[drawn]),
        "specific_force": _known(m.specific_force[drawn]),
    }


def table_view(m: Message, room: Room) -> dict[str, Any]:
    """The last rows of a message's table, as texts; readings: how many rows there are."""
    rows = m.columns[0].shape[:1] if m.columns else ()
    count = len(getattr(m, m.columns[0].name)) if rows and isinstance(rows[0], str) else 1
    last = m.where(slice(-MOST_ROWS, None)) if count > MOST_ROWS else m
    table = table_of(last, room)[:MOST_COLUMNS]
    return {
        "readings": count,
        "head": [
            f"{cells.name}, {cells.unit}" if cells.unit not in ("", "1") else cells.name for cells in table
        ],
        "rows": [[_text(value) for value in row] for row in rows_of(table)][-MOST_ROWS:],
    }


def _known(vectors: np.ndarray) -> list[list[float | None]]:
    """Nested lists; a value that is not finite becomes None, because JSON has no NaN."""
    return [[v if np.isfinite(v) else None for v in row] for row in vectors.round(_DIGITS).tolist()]


def _text(value: Any) -> str:
    """A value in few characters."""
    if isinstance(value, float):
        return f"{value:.{_DIGITS + 1}g}"
    text = "–" if value is None else str(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
