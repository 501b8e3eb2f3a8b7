"""Edges that stall: their writer has no room to send, though their reader waits for messages of them.

An edge stalls if credit never comes back: a peer without a certificate pretends to be the reader, or a
transport has a mistake.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from followspot.control.host import WorkerStatus

_STALLED = 5.0
"""Seconds for which a writer has no room; statuses of both ends are at most a second old."""


def stalled_edges(workers: Iterable[WorkerStatus]) -> Iterator[str]:
    """A line for each edge that stalls."""
    stages = [stage for worker in workers if worker.phase == "running" for stage in worker.stages]
    readers = {edge: stage.stage for stage in stages if stage.state == "getting" for edge in stage.on}
    for writer in stages:
        if writer.state == "sending" and writer.idle_s > _STALLED:
            for edge in writer.on:
                if edge in readers:
                    line = f"{edge} stalls: {writer.stage} has had no room to send for {writer.idle_s:.0f} s"
                    yield f"{line}, though {readers[edge]} waits for its messages"
