"""A run as everybody holds it: for the command line, the page, tools, notebooks and tests."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from followspot.control.dispatch import Request
from followspot.control.lifecycle import StopRun
from followspot.control.observation import GetLog
from followspot.control.tapping import PlaceTaps, Tapping
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data
from followspot.log.record import LogPage
from followspot.operator.changed import Changed, Moved
from followspot.operator.run_requests import (
    ChangeStages,
    GetPlan,
    GetStatus,
    GetSurroundings,
    MoveStages,
    Surroundings,
)
from followspot.operator.run_status import RunStatus
from followspot.plugins.registry import use_plugin_files

ANSWER = 10.0
"""Seconds that a run may take to answer; one that is setting up its stages takes long."""
_CHANGE = 120.0
"""Seconds that a change may take: stages are built beside those that work."""


class NoAnswer(FollowspotError):
    """The run's process is there, but does not answer in time: it is suspended, or very busy."""


Ask = Callable[[Request, float], Any]
"""Carries a request to the run; its answer.

Raises NoAnswer if none comes within so many seconds, FollowspotError if the run has ended or refuses.
"""


class RunHandle:
    """A run: how it is, what it says, and what can be done to it.

    Every method is safe from any thread and raises FollowspotError if the run has ended or refuses.
    run: its name; graph: the name of its graph, "" if it does not answer; ask: reaches it; pid: of its
    operator's process if that is on this machine.
    """

    def __init__(self, run: str, graph: str, ask: Ask, pid: int | None = None) -> None:
        self.run = run
        self.graph = graph
        self.ask = ask
        self.pid = pid

    @property
    def label(self) -> str:
        """For lists of runs."""
        silent = f"{self.run[:8]} of process {self.pid}, which does not answer"
        return f"{self.graph} ({self.run[:8]})" if self.graph else silent

    def plan(self) -> Plan:
        """As it is now, with its one-file plugins loaded."""
        plan = plan_from_data(self.ask(GetPlan(), ANSWER))
        use_plugin_files(plan.plugin_files)
        return plan

    def status(self, timeout: float = ANSWER) -> RunStatus:
        """How the run is now. timeout: seconds after which NoAnswer is raised."""
        found: RunStatus = self.ask(GetStatus(), timeout)
        return found

    def log(self, after: int = -1) -> LogPage:
        """The records after the one of this number."""
        found: LogPage = self.ask(GetLog(after=after), ANSWER)
        return found

    def surroundings(self) -> Surroundings:
        """Its output folder, and a network that leads to its other hosts."""
        found: Surroundings = self.ask(GetSurroundings(), ANSWER)
        return found

    def set(self, parameter: str, value: Any) -> Changed:
        """Set a parameter while the run goes on: ``set("color.similarity", 0.85)``."""
        return self.change([f"{parameter}={value if isinstance(value, str) else json.dumps(value)}"])

    def swap(self, stage: str, uses: str, *, fresh: bool = False) -> Changed:
        """Let another plugin stage take the place of one that works: ``swap("fuse", "balls.mean")``."""
        return self.change([f"{stage}={uses}"], fresh=fresh)

    def change(self, words: Sequence[str], *, folder: Path = Path(), fresh: bool = False) -> Changed:
        """Several swaps (`fuse=balls.mean`) and parameters (`color.similarity=0.7`), all or none.

        Replacements are built beside the stages that work and take over between two firings, with the state
        of the old ones where both know how, unless `fresh`. folder: what paths are relative to.
        """
        request = ChangeStages(words=tuple(words), folder=folder.absolute(), fresh=fresh)
        found: Changed = self.ask(request, _CHANGE)
        return found

    def move(self, stages: Sequence[str], place: str) -> Moved:
        """Bring stages of a live run to another worker, or to a host in reach of it.

        Workers whose stages or kinds of edges change begin anew with the state of their stages; what is under
        way to and from them is lost and counted.
        """
        found: Moved = self.ask(MoveStages(stages=tuple(stages), place=place), _CHANGE)
        return found

    def tap(self, taps: Sequence[Tapping]) -> None:
        """Put sinks at ports."""
        self.ask(PlaceTaps(taps=tuple(taps)), ANSWER)

    def stop(self) -> None:
        """End the sources; what is in flight is finished."""
        self.ask(StopRun(), ANSWER)

    def over(self) -> bool:
        """Whether the run has ended; one that does not answer has not."""
        try:
            return all(worker.phase == "over" for worker in self.status().workers)
        except NoAnswer:
            return False
        except FollowspotError:
            return True
