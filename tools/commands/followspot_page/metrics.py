"""The run's figures in the text format of Prometheus (version 0.0.4)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from followspot.graph.plan import PlannedEdge
from followspot.library.handle import LOSSES, SOURCE_LOSSES, is_old, is_stale
from followspot.messages import Message
from followspot.room import Room
from followspot.tracking import STATES, Tracks
from followspot_watch.run_monitor import RunMonitor

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
SILENCE = 2.0
"""Seconds after the last message about targets until their states are old."""
_BEST = ("lost", "missing", "predicted", "tracked")
"""States in the order in which they count if trackers differ."""
_OUTCOMES = ("away", "delivered", *LOSSES, "in_flight")


class Targets:
    """The state of each target, from the newest messages about targets: the best of all trackers.

    monotonic: a clock, s.
    """

    def __init__(self, room: Room, monotonic: Callable[[], float] = time.monotonic) -> None:
        self.names = tuple(room.targets)
        self._received: dict[str, tuple[float, Mapping[str, str]]] = {}
        """Of each port when it was heard last, s, and its states."""
        self._clock = monotonic

    @property
    def age_s(self) -> float | None:
        """Seconds since the last message about targets; None if there was none."""
        return self._clock() - max(taken for taken, _ in self._received.values()) if self._received else None

    @property
    def state(self) -> Mapping[str, str]:
        """The state of each target, "old" without a recent message."""
        if not self._received:
            return {}
        recent = [states for taken, states in self._received.values() if self._clock() - taken <= SILENCE]
        return {name: max((s[name] for s in recent), key=_BEST.index, default="old") for name in self.names}

    def take(self, port: str, message: Message) -> None:
        """Take a message of a port; one that is not about targets has no effect."""
        if not isinstance(message, Tracks):
            return
        known = [(int(t), STATES[s]) for t, s in zip(message.target, message.state, strict=True)]
        found = {self.names[target]: state for target, state in known if target < len(self.names)}
        self._received[port] = self._clock(), dict.fromkeys(self.names, "lost") | found


def text(
    run: RunMonitor, targets: Targets, browsers: int, refused: Mapping[str, int] = MappingProxyType({})
) -> str:
    """All figures. browsers: number of viewers; refused: connections and messages of others, by reason."""
    turned_away = [({"reason": reason}, count) for reason, count in sorted(refused.items())]
    figures = [
        Figure("page_browsers", "gauge", "Browsers that look on.", [({}, browsers)]),
        Figure("page_refused_total", "counter", "Connections that were refused or cut off.", turned_away),
        Figure("target_state", "gauge", "1 for the state that a target is in.", _states(targets)),
        Figure("target_age_seconds", "gauge", "Since a message about targets.", _known({}, targets.age_s)),
        *(figure for part in (_whole, _hosts, _edges, _stages, _workers) for figure in part(run)),
    ]
    return "".join(figure.text() for figure in figures)


@dataclass(frozen=True)
class Figure:
    """One figure with all its samples."""

    name: str
    kind: Literal["counter", "gauge"]
    about: str
    samples: Iterable[tuple[Mapping[str, str], float]]

    def text(self) -> str:
        """The figure in the format of Prometheus."""
        name = f"followspot_{self.name}"
        lines = [f"# HELP {name} {self.about}", f"# TYPE {name} {self.kind}"]
        lines += [f"{name}{_labels(labels)} {value:.10g}" for labels, value in self.samples]
        return "\n".join(lines) + "\n"


def _whole(run: RunMonitor) -> Iterator[Figure]:
    fired = run.status.fired if run.status else 0
    yield Figure("frames_total", "counter", "Frames that came to the end of the graph.", [({}, fired)])
    yield Figure("status_age_seconds", "gauge", "Since the run answered last.", [({}, run.age_s)])
    yield Figure("faults", "gauge", "What is absent or was not heard lately.", [({}, len(run.faults()))])


def _hosts(run: RunMonitor) -> Iterator[Figure]:
    hosts = run.status.hosts if run.status else ()
    absent = [({"host": host.name}, host.absent) for host in hosts]
    ages = [sample for host in hosts for sample in _known({"host": host.name}, host.age_s)]
    yield Figure("host_absent", "gauge", "1 if a host does not answer.", absent)
    yield Figure("host_age_seconds", "gauge", "Since a host was last heard.", ages)


def _edges(run: RunMonitor) -> Iterator[Figure]:
    edges = [(_ends(edge), count) for edge, count in run.edges()]
    produced = [(ends, count.produced) for ends, count in edges]
    sent = [(ends, count.sent) for ends, count in edges]
    became = [
        ({**ends, "outcome": outcome}, getattr(count, outcome))
        for ends, count in edges
        for outcome in _OUTCOMES
    ]
    yield Figure("edge_produced_total", "counter", "Messages made for an edge.", produced)
    yield Figure("edge_sent_total", "counter", "Messages sent on an edge: all but those away.", sent)
    lost = [({**ends, "how": how}, getattr(count, how)) for ends, count in edges for how in SOURCE_LOSSES]
    yield Figure("edge_source_lost_total", "counter", "Frames that a device made and that never came.", lost)
    yield Figure("edge_messages", "gauge", "What became of them; the sum is what was produced.", became)
    ends_of = {edge.name: _ends(edge) for edge, _ in run.edges()}
    ages = [
        ({**ends_of[age.name], "quantile": quantile}, ms / 1000.0)
        for worker, stage in run.stages()
        if not is_stale(worker)
        for age in stage.edges
        for quantile, ms in (("0.5", age.p50_ms), ("0.95", age.p95_ms))
        if ms is not None and age.name in ends_of
    ]
    yield Figure("edge_age_seconds", "gauge", "Age of an edge's last messages when they were taken.", ages)


def _stages(run: RunMonitor) -> Iterator[Figure]:
    stages = [({"stage": stage.stage}, stage) for _, stage in run.stages()]
    fired = [(name, stage.fired) for name, stage in stages]
    skipped = [(name, stage.skipped) for name, stage in stages]
    busy = [(name, stage.busy_ms / 1000.0) for name, stage in stages]
    yield Figure("stage_fired_total", "counter", "Firings of a stage.", fired)
    yield Figure("stage_skipped_total", "counter", "Firings that raised and were skipped.", skipped)
    yield Figure("stage_busy_seconds_total", "counter", "Time that a stage has worked.", busy)


def _workers(run: RunMonitor) -> Iterator[Figure]:
    workers = [({"worker": worker.name}, worker) for worker in run.workers()]
    restarts = [(name, worker.restarts) for name, worker in workers]
    running = [(name, worker.phase == "running" and not is_old(worker)) for name, worker in workers]
    ages = [sample for name, worker in workers for sample in _known(name, worker.age_s)]
    latency = [
        ({"from": path.origin, "to": path.sink, "quantile": quantile}, ms / 1000.0)
        for worker in run.workers()
        if not is_stale(worker)
        for path in worker.paths
        for quantile, ms in (("0.5", path.p50_ms), ("0.95", path.p95_ms))
    ]
    yield Figure("worker_restarts_total", "counter", "How often a worker was started again.", restarts)
    yield Figure("worker_running", "gauge", "1 if a worker runs and was heard lately.", running)
    yield Figure("worker_age_seconds", "gauge", "Since a worker was last heard.", ages)
    yield Figure("path_latency_seconds", "gauge", "From a source to a sink, since the start.", latency)


def _states(targets: Targets) -> list[tuple[Mapping[str, str], float]]:
    return [
        ({"target": name, "state": state}, state == now)
        for name, now in targets.state.items()
        for state in (*STATES, "old")
    ]


def _known(labels: Mapping[str, str], value: float | None) -> list[tuple[Mapping[str, str], float]]:
    """A sample, if its value is known."""
    return [] if value is None else [(labels, value)]


def _ends(edge: PlannedEdge) -> Mapping[str, str]:
    return {"from": f"{edge.from_stage}.{edge.from_port}", "to": f"{edge.to_stage}.{edge.to_port}"}


def _labels(labels: Mapping[str, str]) -> str:
    if not labels:
        return ""
    return "{" + ",".join(f'{name}="{_escaped(value)}"' for name, value in labels.items()) + "}"


def _escaped(text: str) -> str:
    return text.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")
