"""A model of a graph that runs in workers: how long a frame set takes, and how many come in a second.

Each worker does one firing at a time, at most as many as there are cores work at once, and older frame sets
come first. A message to another worker costs both ends processor time, and arrives later. Feedback with a
delay of d makes frame n wait for frame n - d, which is why more workers are not always faster.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from followspot.graph.cycles import cyclic, successors, topological

HOP_WORK = 0.1
"""Processor time of each end of a message between two workers, ms (docs/speed.md: 0.11 to 0.3 for both)."""
HOP_WAIT = 0.1
"""Time from one worker to another, ms (docs/speed.md)."""
_WINDOW = 8
"""Frame sets under way at once: the depth of an edge."""
_FRAMES = 32
"""Frame sets that are modelled for the period, from the first one's source to the last one's sink."""
_ALONE = 4
"""Frame sets that are modelled one after the other, for latency."""


@dataclass(frozen=True)
class Timing:
    """The prediction of the model. period, latency: of a frame set, ms; latency is that of a set alone."""

    period: float
    latency: float


@dataclass(frozen=True)
class PipelineModel:
    """A graph of stage instances. work: ms a frame set; wires: from, to, delay; cores: of this host.

    remote: instances on other hosts, whose cores are not counted.
    """

    work: Mapping[str, float]
    wires: Sequence[tuple[str, str, int]]
    cores: int
    remote: frozenset[str] = frozenset()
    order: Mapping[str, int] = field(init=False)
    """Topological rank of each instance."""

    def __post_init__(self) -> None:
        forward = self._forward()
        ranked = topological(successors(self.work, [(start, end) for start, end, _ in forward]))
        object.__setattr__(self, "order", {name: rank for rank, name in enumerate(ranked)})

    def _forward(self) -> list[tuple[str, str, int]]:
        """Wires on which a stage waits for the same frame: not those of cycles, whose inputs are sampled."""
        direct = [wire for wire in self.wires if not wire[2]]
        circular = cyclic([(start, end) for start, end, _ in direct])
        return [wire for wire in direct if wire[:2] not in circular]

    def timing(self, worker_of: Mapping[str, str]) -> Timing:
        """Period and latency in this placement."""
        period = max(end for _, end in _Run(self, worker_of, _FRAMES, _WINDOW).ends()) / _FRAMES
        alone = _Run(self, worker_of, _ALONE, 1).ends()
        return Timing(period, sum(end - entered for entered, end in alone) / _ALONE)

    def latency_to(self, end: Sequence[str], worker_of: Mapping[str, str]) -> float:
        """Time, ms, from the first source of a frame set alone until the last of these instances is done."""
        run = _Run(self, worker_of, _ALONE, 1)
        entered = [first for first, _ in run.ends()]
        return max(run.done[name, number] - entered[number] for name in end for number in range(_ALONE))

    def inputs(self) -> Mapping[str, list[tuple[str, int]]]:
        """Sender and delay of the messages for which each instance waits."""
        found: dict[str, list[tuple[str, int]]] = {name: [] for name in self.work}
        for start, end, delay in (*self._forward(), *(wire for wire in self.wires if wire[2])):
            found[end].append((start, delay))
        return found


class _Wait(NamedTuple):
    """One event that a firing waits for: the end of another firing, and `hop` ms.

    name: of the other instance; delay: frames.
    """

    name: str
    delay: int
    hop: float = 0.0


class _Run:
    """One simulation: events in the order of time, then of frames and ranks, so that it is deterministic."""

    def __init__(self, model: PipelineModel, worker_of: Mapping[str, str], frames: int, window: int) -> None:
        self.model, self.worker_of, self.frames = model, worker_of, frames
        inputs = model.inputs()
        senders = {start for start, _, delay in model.wires if not delay}
        self.sources = [name for name in model.work if not any(not d for _, d in inputs[name])]
        self.sinks = [name for name in model.work if name not in senders]
        self.cost = dict(model.work)
        self.readers: Mapping[str, list[_Wait]] = defaultdict(list)
        """The same waits by the instance that is waited for; each has the name of the one that waits."""
        self.missing: dict[tuple[str, int], int] = {}
        for name, waits in self._waits(inputs, window).items():
            for number in range(frames):
                self.missing[name, number] = sum(number >= delay for _, delay, _ in waits)
            for other, delay, hop in waits:
                self.readers[other].append(_Wait(name, delay, hop))
        self.done: dict[tuple[str, int], float] = {}
        self._simulate()

    def _waits(self, inputs: Mapping[str, list[tuple[str, int]]], window: int) -> dict[str, list[_Wait]]:
        """The waits of each instance: for itself, its inputs, and the sinks `window` frames ago (sources).

        Adds the work of messages between workers to the cost of their ends.
        """
        waits = {name: [_Wait(name, 1)] for name in self.model.work}
        for end, found in inputs.items():
            for start, delay in found:
                hop = self.worker_of[start] != self.worker_of[end]
                self.cost[start] += HOP_WORK * hop
                self.cost[end] += HOP_WORK * hop
                waits[end].append(_Wait(start, delay, HOP_WAIT * hop))
        for source in self.sources:
            waits[source] += [_Wait(sink, window) for sink in self.sinks]
        return waits

    def ends(self) -> list[tuple[float, float]]:
        """Of each frame set: when its first source was done, and when its last sink was, ms."""
        return [
            (
                min(self.done[name, number] for name in self.sources),
                max(self.done[name, number] for name in self.sinks),
            )
            for number in range(self.frames)
        ]

    def _simulate(self) -> None:
        """Start ready firings, oldest first, while cores and workers are free; then go to the next event."""
        rank, remote = self.model.order, self.model.remote
        free, busy = self.model.cores, set[str]()
        ready = [(n, rank[name], name) for (name, n), missing in self.missing.items() if not missing]
        heapq.heapify(ready)
        events: list[tuple[float, int, int, str, str]] = []
        now = 0.0
        while ready or events:
            waiting = []
            while ready:
                number, _, name = task = heapq.heappop(ready)
                here = name not in remote
                if self.worker_of[name] in busy or (here and not free):
                    waiting.append(task)
                    continue
                busy.add(self.worker_of[name])
                free -= here
                heapq.heappush(events, (now + self.cost[name], number, rank[name], "done", name))
            ready = waiting
            now, number, _, what, name = heapq.heappop(events)
            if what == "done":
                self.done[name, number] = now
                busy.discard(self.worker_of[name])
                free += name not in remote
                for reader, delay, wait in self.readers[name]:
                    if number + delay < self.frames:
                        event = (now + wait, number + delay, rank[reader], "input", reader)
                        heapq.heappush(events, event)
            else:
                self.missing[name, number] -= 1
                if not self.missing[name, number]:
                    heapq.heappush(ready, (number, rank[name], name))
