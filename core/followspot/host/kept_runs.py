"""The files from which a restarted agent resumes the detached runs of an earlier one.

The resumed workers have higher incarnation numbers than those of the earlier agent, and carry on from the
checkpoints that it left.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from followspot.control.host import RunOrder
from followspot.control.lifecycle import PrepareRun
from followspot.files import read_bytes
from followspot.host.agent_run import AgentRun

_FILE = ".order"
_MAX_AGE = 600.0
"""Age, s, above which a saved run is not resumed."""
_SAVE_PERIOD = 2.0
"""Seconds between two saves."""


class KeptRuns:
    """The saved orders of detached runs, each a file in the run's output folder."""

    def __init__(self, runs: Path, host: str) -> None:
        """runs: folder that contains the output folders; host: name of the agent's host."""
        self._runs = runs
        self._host = host
        self._next = 0.0

    def left(self) -> Iterator[RunOrder]:
        """The orders of the runs that an earlier agent of this host had when it died, unless too old."""
        for path in sorted(self._runs.glob(f"*-{self._host}/{_FILE}")):
            with suppress(OSError, ValueError):  # incomplete, or of another version
                away = time.time() - path.stat().st_mtime
                if away > _MAX_AGE:
                    continue
                order = PrepareRun.model_validate_json(read_bytes(path)).order
                if path.parent.name.endswith(f"-{order.run}-{self._host}"):
                    yield replace(order, age_s=order.age_s + max(0.0, away))

    def keep(self, agent_runs: Iterable[AgentRun], now: float) -> None:
        """Save the detached runs if the last save is old enough; now: monotonic time, s."""
        if now < self._next:
            return
        self._next = now + _SAVE_PERIOD
        for agent_run in agent_runs:
            if agent_run.over:
                self.forget(agent_run)
            elif agent_run.order.detached and agent_run.started:
                path = Path(agent_run.run.out, _FILE)
                with suppress(OSError):  # a full disk must not end the run
                    new = path.with_suffix(".new")
                    new.write_text(PrepareRun(order=agent_run.resume_order()).model_dump_json())
                    new.replace(path)

    def forget(self, agent_run: AgentRun) -> None:
        """Remove the saved order of a run."""
        with suppress(OSError):
            Path(agent_run.run.out, _FILE).unlink(missing_ok=True)
