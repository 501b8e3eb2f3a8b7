"""Units of times, conversion between them, and capture times of recordings.

Capture times are computed in exact integer arithmetic, so that every replay has the same ones.
"""

from __future__ import annotations

from fractions import Fraction

SECOND = 1_000_000_000
"""ns, the unit of all times of messages."""
NANOSECOND = 1e-9
"""s, for differences of such times."""


def to_ns(seconds: float) -> int:
    """A time or duration, s, in the unit of messages: ns, rounded."""
    return round(seconds * 1e9)


def to_seconds(ns: int) -> float:
    """A time or duration of messages, ns, in seconds."""
    return ns / 1e9


def exact_rate(fps: float) -> Fraction:
    """Frames per second as a ratio: 29.97002997 becomes 30000/1001. Raises ValueError below 1/1001."""
    rate = Fraction(fps).limit_denominator(1001)
    if rate <= 0:
        raise ValueError(f"{fps} frames per second")
    return rate


def capture_time(frame: int, rate: Fraction) -> int:
    """Time of a frame since the first one, ns, rounded down: frame / rate."""
    return frame * SECOND * rate.denominator // rate.numerator
