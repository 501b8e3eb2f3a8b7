"""Latency from a source to a sink: quantiles from a histogram of fixed size, and the worst message."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from collections.abc import Mapping
from itertools import accumulate
from types import MappingProxyType

from followspot.control.path_latency import PathLatency
from followspot.control.stage_status import PathStatus
from followspot.messages import Header

MOST_PATHS = 64
"""Sources whose latency to a sink is measured one by one; more names than these take no memory."""
OTHERS = "others"
"""Stands for all further sources."""
_NEWEST, _FEWEST = 100, 20
"""Messages by which it is judged whether a path keeps its budget now: at most, and at least."""
_GROWTH = math.log(1.02)
_BINS = 1400
"""1 ns x 1.02^1400 is about 18 minutes; a bin is 2 % wide."""


class LatencyHistogram:
    """Latencies of one path from a source to a sink; memory does not grow with the run."""

    __slots__ = ("bins", "count", "late", "limit", "newest", "worst", "worst_id")

    def __init__(self, limit: int = 0) -> None:
        """limit: the budget of the path, ns; 0 for none."""
        self.limit = limit
        self.late = 0
        """Messages that took longer than the budget."""
        self.newest: deque[int] = deque(maxlen=_NEWEST if limit else 0)
        """Latencies of the newest messages of a path with a budget, ns."""
        self.bins = [0] * _BINS
        self.count = 0
        self.worst = 0
        self.worst_id = ""

    def add(self, elapsed: int, source: str, seq: int) -> None:
        """Count one message; elapsed: ns from entering the graph to the sink's firing."""
        self.bins[min(_BINS - 1, int(math.log(elapsed) / _GROWTH)) if elapsed > 1 else 0] += 1
        self.count += 1
        if self.limit:
            self.late += elapsed > self.limit
            self.newest.append(elapsed)
        if elapsed > self.worst:
            self.worst, self.worst_id = elapsed, f"{source}#{seq}"

    def quantile(self, share: float) -> float:
        """The latency, ms, below which this share of the messages lies, accurate to 2 %."""
        if not self.count:
            return 0.0
        counts = list(accumulate(self.bins))
        index = bisect_left(counts, max(1, share * counts[-1]))
        return math.exp((index + 0.5) * _GROWTH) / 1e6

    def status(self, origin: str, sink: str) -> PathStatus:
        """The path until now; safe from another thread."""
        budget = self.limit / 1e6 if self.limit else None
        newest = sorted(self.newest.copy())
        recent = newest[int(0.95 * (len(newest) - 1))] / 1e6 if len(newest) >= _FEWEST else None
        quantiles = self.quantile(0.5), self.quantile(0.95)
        return PathStatus(origin, sink, *quantiles, self.count, budget, self.late, recent)

    def summary(self, origin: str, sink: str) -> PathLatency:
        """Median, 95th and 99th percentiles and maximum of the path."""
        return PathLatency(
            origin=origin,
            sink=sink,
            count=self.count,
            p50_ms=self.quantile(0.5),
            p95_ms=self.quantile(0.95),
            worst_ms=self.worst / 1e6,
            worst_id=self.worst_id,
            budget_ms=self.limit / 1e6 if self.limit else None,
            late=self.late,
            p99_ms=self.quantile(0.99),
        )


class PathLatencies(dict[str, LatencyHistogram]):
    """Latencies of all paths to one sink, by the stage of the graph file whose instance is the source."""

    def __init__(self, groups: Mapping[str, str], limits: Mapping[str, int] = MappingProxyType({})) -> None:
        """groups: stage of the graph file, by instance; limits: budgets, ns, by origin."""
        super().__init__()
        self.groups = groups
        self.limits = limits

    def add(self, header: Header, now: int) -> None:
        """Count the firing of the sink. header: of its input; now: steady time of the run, ns."""
        origin = self.groups.get(header.source, header.source)
        path = self.get(origin)
        if path is None:
            origin = origin if len(self) < MOST_PATHS else OTHERS
            path = self.setdefault(origin, LatencyHistogram(self.limits.get(origin, 0)))
        path.add(now - header.entered, header.source, header.seq)

    def add_budgeted(self, header: Header, now: int) -> None:
        """Like `add`, for a stage that is no sink: only paths with a budget count."""
        if self.groups.get(header.source, header.source) in self.limits:
            self.add(header, now)
