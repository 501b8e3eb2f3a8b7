"""Faults of a run that mark a moment by themselves."""

from __future__ import annotations

from followspot.library.handle import RunStatus


class FaultWatch:
    """Finds new faults between two statuses of a run: a stage that failed or was restarted, a worker
    or host that is silent.
    """

    def __init__(self) -> None:
        self._errors: dict[str, tuple[str, int, int]] = {}
        self._kinds: frozenset[str] = frozenset()

    def new_faults(self, status: RunStatus) -> list[str]:
        """A line for each new fault."""
        stages = [stage for worker in status.workers for stage in worker.stages]
        found = []
        for stage in stages:
            now = stage.error, stage.skipped, stage.restarts
            if stage.error and now != self._errors.get(stage.stage, ("", 0, 0)):
                found.append(f"{stage.stage}: {stage.error.strip().splitlines()[-1]}")
            self._errors[stage.stage] = now
        lines = {_kind(line): line for line in status.faults()}
        found += [line for kind, line in lines.items() if kind not in self._kinds]
        self._kinds = frozenset(lines)
        return found


def _kind(line: str) -> str:
    """A fault without how long it lasts."""
    return line.partition(":")[0].partition(" was last heard")[0]
