"""Latency of the path from a source to a sink."""

from __future__ import annotations

from dataclasses import dataclass

from followspot.valid_values.numbers import Count, Figure


@dataclass(frozen=True)
class PathLatency:
    """Latency of one path, ms. worst_id: the frame with the worst latency; budget_ms: the longest
    time allowed, None if it has no budget; late: messages that took longer.
    """

    origin: str
    sink: str
    count: Count
    p50_ms: Figure
    p95_ms: Figure
    worst_ms: Figure
    worst_id: str
    budget_ms: Figure | None = None
    late: Count = 0
    p99_ms: Figure = 0.0
