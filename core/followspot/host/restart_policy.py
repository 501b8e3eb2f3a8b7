"""Restart policy: whether and when a dead worker is restarted."""

from __future__ import annotations

from collections.abc import Collection

from followspot.graph.plan import Plan

_FIRST_WAIT, _LONGEST_WAIT = 0.1, 2.0
"""Shortest and longest wait before a restart, s; it doubles with each death in a row.

With the silence after which a worker counts as hanging and the second that a start takes, a worker is back
within five seconds however often it died before.
"""
_ROW_WINDOW = 10.0
"""Two deaths of a worker count as in a row if they are less than this apart, s."""


class BackOff:
    """Wait before a dead worker is restarted: exponential for deaths in a row."""

    def __init__(self) -> None:
        self._died: dict[str, float] = {}
        self._row: dict[str, int] = {}

    def wait(self, name: str, now: float) -> float:
        """The wait, s, after a death at monotonic time `now`, s; short again after a long life."""
        in_a_row = now - self._died.get(name, -_ROW_WINDOW) < _ROW_WINDOW
        self._row[name] = self._row[name] + 1 if in_a_row else 0
        self._died[name] = now
        return float(min(_LONGEST_WAIT, _FIRST_WAIT * 2 ** min(self._row[name], 30)))


class RestartPolicy:
    """Dead workers, and the time at which each is due for a restart."""

    def __init__(self) -> None:
        self._back_off = BackOff()
        self._due: dict[str, float] = {}

    @property
    def waiting(self) -> tuple[str, ...]:
        """Workers to be restarted."""
        return tuple(self._due)

    def after_death(self, name: str, now: float) -> float:
        """Schedule the restart of a worker that died at `now`; return the wait, s."""
        wait = self._back_off.wait(name, now)
        self._due[name] = now + wait
        return wait

    def due(self, now: float) -> list[str]:
        """Remove and return the workers whose restart is due."""
        names = [name for name, at in self._due.items() if at <= now]
        for name in names:
            del self._due[name]
        return names

    def call_off(self, name: str) -> None:
        """Cancel the restart of a worker."""
        self._due.pop(name, None)


def may_get_messages(plan: Plan, worker: str, over: Collection[str]) -> bool:
    """True if the worker has a source, or an upstream worker that is not over."""
    fed_stages = {edge.to_stage for edge in plan.edges}
    mine = [stage.name for stage in plan.stages if stage.worker == worker]
    return any(stage not in fed_stages for stage in mine) or any(
        plan.worker_of(edge.to_stage) == worker and plan.worker_of(edge.from_stage) not in {worker, *over}
        for edge in plan.edges
    )
