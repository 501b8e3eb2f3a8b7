"""When a worker counts as hanging, and whether and when one that died is started again."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from followspot.graph.plan import Plan

SILENCE = 1.5
"""Seconds without a word after which a running worker counts as hanging; they speak five times a second."""
_FIRST_WAIT, _LONGEST_WAIT = 0.1, 5.0
"""Seconds before the first restart, and before any; it doubles each time."""
_ROW = 10.0
"""Seconds between two deaths of a worker within which they count as in a row."""
_PAUSE = 0.6
"""Seconds between two looks that say that it was the observer who slept."""


class BackOff:
    """How long to wait before a worker that died is started again: longer for deaths in a row."""

    def __init__(self) -> None:
        self._died: dict[str, float] = {}
        self._row: dict[str, int] = {}

    def wait(self, name: str, now: float) -> float:
        """Seconds; now: when it died, s. Who lived for a while before begins with a short wait again."""
        in_a_row = now - self._died.get(name, -_ROW) < _ROW
        self._row[name] = self._row[name] + 1 if in_a_row else 0
        self._died[name] = now
        return float(min(_LONGEST_WAIT, _FIRST_WAIT * 2 ** min(self._row[name], 30)))


class RestartPolicy:
    """Workers that are away, and when each is to be started again."""

    def __init__(self) -> None:
        self._back_off = BackOff()
        self._due: dict[str, float] = {}

    @property
    def waiting(self) -> tuple[str, ...]:
        """Who is to be started."""
        return tuple(self._due)

    def after_death(self, name: str, now: float) -> float:
        """Start it again after a while; how long that is, s. now: when it died, s."""
        wait = self._back_off.wait(name, now)
        self._due[name] = now + wait
        return wait

    def due(self, now: float) -> list[str]:
        """Who is to be started now, and waits no more."""
        names = [name for name, at in self._due.items() if at <= now]
        for name in names:
            del self._due[name]
        return names

    def call_off(self, name: str) -> None:
        """Do not start it again."""
        self._due.pop(name, None)


def fed(plan: Plan, worker: str, over: Collection[str]) -> bool:
    """Whether anything can still come to a worker: it has a source, or one that feeds it is not over."""
    fed_stages = {edge.to_stage for edge in plan.edges}
    mine = [stage.name for stage in plan.stages if stage.worker == worker]
    return any(stage not in fed_stages for stage in mine) or any(
        plan.worker_of(edge.to_stage) == worker and plan.worker_of(edge.from_stage) not in {worker, *over}
        for edge in plan.edges
    )


class Heartbeat:
    """Listens for the heartbeat of workers; pauses of the listener itself are nobody's fault."""

    def __init__(self) -> None:
        self._looked = 0.0
        self._slept_until = 0.0

    def silent(self, heard: Mapping[str, float], now: float) -> list[str]:
        """Who has not been heard for too long. heard: when each last was, s; now: the time, s."""
        if now - self._looked > _PAUSE:
            self._slept_until = now
        self._looked = now
        return [name for name, at in heard.items() if now - max(at, self._slept_until) > SILENCE]
