"""Where the time from capture to a result went: the path of the inputs that came last, back to the camera.

Each nanosecond from the time at which a frame set is due until the last stage has sent its result belongs to
one part. While the path waits in a worker, what that worker does meanwhile tells the part.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from followspot.graph.plan import Plan, PlannedEdge
from followspot.messages import Array

STAGES, OTHERS, DECODING = "stages", "other stages", "decoding"
FORECAST, HOPS, LATE, RUNTIME = "forecast", "hops", "late frame", "runtime"
PARTS = (STAGES, OTHERS, DECODING, FORECAST, HOPS, LATE, RUNTIME)
"""Stages of the path; others and decoding that it waits for in a worker; the forecast of the frame set
before; hops between workers; a frame that enters later than it is due while its worker does nothing else; all
that is left.
"""


class Made(NamedTuple):
    """A frame: when it was due and when it entered the graph, ns."""

    due: int
    entered: int


class Fired(NamedTuple):
    """A firing: when it took its inputs, had its result, and had sent it, ns."""

    taken: int
    ended: int
    sent: int


class Way(NamedTuple):
    """What one frame set took, ns by part, and over how many hops between workers it came.

    waited: how much of all that the path's workers were ready to run and had no core, ns.
    """

    parts: Mapping[str, int]
    hops: int
    waited: int

    @property
    def total(self) -> int:
        """From the time at which the frame set was due, ns."""
        return sum(self.parts.values())


@dataclass(frozen=True)
class _Busy:
    """What a worker did, in turn: (N,) ns each, and the part it is for a path that waits meanwhile."""

    begun: Array
    ended: Array
    parts: tuple[str, ...]


class Trace:
    """What the workers of a run noted (`benching.live_trace`)."""

    def __init__(self, folder: Path, plan: Plan) -> None:
        """folder: of the notes. Reads them."""
        self.plan = plan
        self.made: dict[tuple[str, int], Made] = {}
        self.fired: dict[str, dict[int, Fired]] = defaultdict(dict)
        """By stage and capture time, in order."""
        self._arrived: dict[tuple[str, int], int] = {}
        self._into: dict[str, list[PlannedEdge]] = defaultdict(list)
        for edge in plan.edges:
            self._into[edge.to_stage].append(edge)
        self._waited: dict[str, Array] = {}
        """By worker, (2, N): times, and how long its thread had waited for a core by then, ns."""
        worked: dict[str, list[tuple[int, int, str]]] = defaultdict(list)
        for file in sorted(folder.glob("*.json")):
            notes = json.loads(file.read_text(encoding="utf-8"))
            for stage, time, due, entered in notes["frames"]:
                self.made[stage, time] = Made(due, entered)
            for stage, time, taken, ended, sent in notes["fired"]:
                self.fired[stage][time] = Fired(taken, ended, sent)
                worked[plan.worker_of(stage)].append((taken, ended, OTHERS))
            for stage, begun, ended in notes["decoded"]:
                worked[plan.worker_of(stage)].append((begun, ended, DECODING))
            for edge, time, arrived in notes["arrived"]:
                self._arrived[edge, time] = arrived
            for stage in {row[0] for row in (*notes["frames"], *notes["fired"])}:
                self._waited[plan.worker_of(stage)] = (
                    np.array(notes["waited"], dtype=np.int64).reshape(-1, 2).T
                )
        self._busy = {worker: _busy(rows) for worker, rows in worked.items()}

    def ways(self, stage: str, lead: int) -> list[Way]:
        """Of all frame sets that this stage has worked on, but the first ones."""
        return [self._way(stage, time) for time in list(self.fired[stage])[lead:]]

    def _way(self, stage: str, time: int) -> Way:
        """Back from the firing of this stage."""
        parts = dict.fromkeys(PARTS, 0)
        hops = waited = 0
        parts[RUNTIME] += self.fired[stage][time].sent - self.fired[stage][time].ended
        while stage in self.fired:
            firing, here = self.fired[stage][time], self.plan.worker_of(stage)
            parts[STAGES] += firing.ended - firing.taken
            came, edge = max(self._came(stage, time), key=lambda found: found[0])
            known = max(came, self._forecast_came(stage, time))
            self._share(parts, here, known, firing.taken, RUNTIME)
            parts[FORECAST] += known - came
            stage = edge.from_stage
            source = stage not in self.fired
            left = self.made[stage, time].entered if source else self.fired[stage][time].ended
            away = edge.kind != "reference"
            hops += away
            self._share(parts, here, left, came, HOPS if away else RUNTIME)
            waited += self._without_core(here, left, firing.ended)
        due, entered = self.made[stage, time]
        self._share(parts, self.plan.worker_of(stage), due, entered, LATE)
        waited += self._without_core(self.plan.worker_of(stage), due, entered)
        return Way(parts, hops, waited)

    def _came(self, stage: str, time: int) -> Iterable[tuple[int, PlannedEdge]]:
        """When the messages of this frame set came, and over which edges."""
        for edge in self._into[stage]:
            if not edge.delay and (edge.name, time) in self._arrived:
                yield self._arrived[edge.name, time], edge

    def _forecast_came(self, stage: str, time: int) -> int:
        """When the feedback that the firing needs came, ns; 0 if it needs none."""
        times = list(self.fired[stage])
        place = times.index(time)
        needed = [(edge, times[place - edge.delay]) for edge in self._into[stage] if 0 < edge.delay <= place]
        return max((self._arrived.get((edge.name, before), 0) for edge, before in needed), default=0)

    def _without_core(self, worker: str, begun: int, ended: int) -> int:
        """How long the worker's thread waited for a core meanwhile, ns, as far as its notes tell."""
        times, waited = self._waited[worker]
        before, after = np.searchsorted(times, (begun, ended), side="right") - 1
        return int(min(waited[after] - waited[max(0, before)], ended - begun)) if after >= 0 else 0

    def _share(self, parts: dict[str, int], worker: str, begun: int, ended: int, rest: str) -> None:
        """Add a wait to what the worker did meanwhile, and what is left of it to `rest`."""
        busy, now = self._busy[worker], begun
        for row in np.flatnonzero((busy.begun < ended) & (busy.ended > begun)):
            since, until = max(now, int(busy.begun[row])), min(ended, int(busy.ended[row]))
            if until > since:
                parts[rest] += since - now
                parts[busy.parts[row]] += until - since
                now = until
        parts[rest] += ended - now


def _busy(rows: list[tuple[int, int, str]]) -> _Busy:
    rows.sort()
    begun, ended, parts = zip(*rows, strict=True)
    return _Busy(np.array(begun), np.array(ended), parts)
