"""Events of a run that the operator itself notices: each is a line in the log and in the report."""

from __future__ import annotations

from followspot.log.merged import MergedLog
from followspot.log.record import Level
from followspot.operator.fault_watch import FaultWatch
from followspot.operator.run_view import RunView


class RunEvents:
    """Notices what begins and ends in a run: missed budgets, edges that stall, the wait for silent hosts.

    lines: all events so far.
    """

    def __init__(self, log: MergedLog) -> None:
        self.lines: list[str] = []
        self._log = log
        self._budgets = FaultWatch(" misses its", " keeps its")
        self._stalls = FaultWatch(" stalls", " moves")
        self._awaited: tuple[str, ...] = ()
        """Silent hosts for which alone the run goes on, as logged last."""

    def add(self, line: str, level: Level) -> None:
        """Log an event, and keep it for the report."""
        self._log.say(level, line)
        self.lines.append(line)

    def notice(self, view: RunView, *, silence: bool) -> None:
        """Add what has begun or ended since the last call.

        silence: whether a host does not answer in a run that is not being stopped.
        """
        if view.plan.budgets and not any(worker.phase == "over" for worker in view.workers()):
            for line, begins in self._budgets.changes(view.late()):
                self.add(line, "warning" if begins else "info")
        for line, begins in self._stalls.changes(view.stalled()):
            self.add(line, "warning" if begins else "info")
        awaited = view.awaited() if silence else ()
        if awaited and awaited != self._awaited:
            names = " and ".join(f"host {name}" for name in awaited)
            line = f"the run waits for {names} alone: start the agent or mend the link there, or stop the run"
            self.add(line, "warning")
        self._awaited = awaited
