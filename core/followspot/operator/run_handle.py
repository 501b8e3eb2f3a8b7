"""The handle on a run that the command line, the page, tools, notebooks and tests use."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any
from uuid import uuid4

from followspot.control.dispatch import Request
from followspot.control.lifecycle import StopRun
from followspot.control.observation import GetLog
from followspot.control.stage_status import StageStatus
from followspot.control.tapping import PlaceTaps, Tapping
from followspot.control.worker_orders import HoldSources
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

ANSWER_TIMEOUT = 10.0
"""Seconds that a run has to answer; a run that is setting up its stages is slow."""
_CHANGE_TIMEOUT = 120.0
"""Seconds that a change has: new stages are built beside those that run."""
_STALLED = 60.0
"""Seconds without a message of any source after which a step fails."""
_POLL_INTERVAL = 0.02
"""Seconds between two polls of a step."""


class NoAnswer(FollowspotError):
    """The run's process is alive but does not answer in time: it is suspended or too busy."""


Ask = Callable[[Request, float], Any]
"""Sends a request to the run and returns its answer; the number is the timeout, s.

Raises NoAnswer after the timeout, FollowspotError if the run has ended or refuses.
"""


class RunHandle:
    """A run: its plan, status and log, and the changes that can be made to it.

    Every method is safe from any thread and raises FollowspotError if the run has ended or refuses.
    run: its name; graph: the name of its graph, "" if it does not answer; ask: sends it requests; pid:
    process id of its operator, if that process is on this machine.
    """

    def __init__(self, run: str, graph: str, ask: Ask, pid: int | None = None) -> None:
        self.run = run
        self.graph = graph
        self.ask = ask
        self.pid = pid

    @property
    def label(self) -> str:
        """Text for lists of runs."""
        silent = f"{self.run[:8]} of process {self.pid}, which does not answer"
        return f"{self.graph} ({self.run[:8]})" if self.graph else silent

    def plan(self) -> Plan:
        """The plan as it is now; loads the one-file plugins of the run."""
        plan = plan_from_data(self.ask(GetPlan(), ANSWER_TIMEOUT))
        use_plugin_files(plan.plugin_files)
        return plan

    def status(self, timeout: float = ANSWER_TIMEOUT) -> RunStatus:
        """The status of the run now. timeout: seconds after which NoAnswer is raised."""
        found: RunStatus = self.ask(GetStatus(), timeout)
        return found

    def log(self, after: int = -1) -> LogPage:
        """The log records after the record of this number."""
        found: LogPage = self.ask(GetLog(after=after), ANSWER_TIMEOUT)
        return found

    def surroundings(self) -> Surroundings:
        """The output folder of the run, and the network that leads to its other hosts."""
        found: Surroundings = self.ask(GetSurroundings(), ANSWER_TIMEOUT)
        return found

    def set(self, parameter: str, value: Any) -> Changed:
        """Set a parameter during the run: ``set("color.similarity", 0.85)``."""
        return self.change([f"{parameter}={value if isinstance(value, str) else json.dumps(value)}"])

    def swap(self, stage: str, uses: str, *, fresh: bool = False) -> Changed:
        """Replace a stage during the run by another plugin stage: ``swap("fuse", "balls.mean")``."""
        return self.change([f"{stage}={uses}"], fresh=fresh)

    def change(self, words: Sequence[str], *, folder: Path = Path(), fresh: bool = False) -> Changed:
        """Make several swaps (`fuse=balls.mean`) and settings (`color.similarity=0.7`), all or none.

        Replacements are built beside the running stages and take over between two firings. They restore the
        state of the old stages if both support it, unless `fresh`. folder: base of relative paths.
        """
        request = ChangeStages(words=tuple(words), folder=folder.absolute(), fresh=fresh)
        found: Changed = self.ask(request, _CHANGE_TIMEOUT)
        return found

    def move(self, stages: Sequence[str], place: str) -> Moved:
        """Move stages of a live run to another worker, or to a host that the run can reach.

        Workers whose stages or kinds of edges change restart from the state of their stages. Messages in
        flight to and from them are lost and counted.
        """
        found: Moved = self.ask(MoveStages(stages=tuple(stages), place=place), _CHANGE_TIMEOUT)
        return found

    def tap(self, taps: Sequence[Tapping]) -> None:
        """Tap ports: their messages also go to the given sinks."""
        self.ask(PlaceTaps(taps=tuple(taps)), ANSWER_TIMEOUT)

    def pause(self) -> None:
        """Hold all sources of a replay; stages process the messages already sent. A live run refuses."""
        self.ask(HoldSources(id=uuid4().hex), ANSWER_TIMEOUT)

    def resume(self) -> None:
        """Let the held sources go on."""
        self.ask(HoldSources(id=uuid4().hex, held=False), ANSWER_TIMEOUT)

    def step(self, count: int = 1, *, source: str | None = None) -> int:
        """Let a replay go on for the next `count` capture times of a source, then pause it again.

        source: for example ``camera/cam0``; by default the first camera's. Every other source sends until it
        has reached the same time. Returns the newest capture time, ns, when the sources have sent these
        messages; stages may still process them. Raises NoAnswer if no source sends for 60 s.
        """
        plan = self.plan()
        fed = {edge.to_stage for edge in plan.edges}
        sources = [stage for stage in plan.stages if stage.name not in fed]
        chosen = source or min(sources, key=lambda stage: stage.camera is None).name
        order = HoldSources(id=uuid4().hex, source=chosen, count=count)
        self.ask(order, ANSWER_TIMEOUT)
        names, times, deadline = {stage.name for stage in sources}, None, 0.0
        while True:
            found = self._stages(names)
            if found is None:
                return order.until
            if chosen in found and found[chosen].time > order.until:
                order = order.model_copy(update={"until": found[chosen].time})
                self.ask(order, ANSWER_TIMEOUT)
            if names == found.keys() and all(_has_stepped(stage, order) for stage in found.values()):
                return order.until
            if times != (times := {stage.stage: stage.time for stage in found.values()}):
                deadline = time.monotonic() + _STALLED
            if time.monotonic() > deadline:
                raise NoAnswer(f"no source has sent anything for {_STALLED:.0f} s")
            time.sleep(_POLL_INTERVAL)

    def _stages(self, names: Collection[str]) -> dict[str, StageStatus] | None:
        """The status of these stages; None if the run has ended."""
        try:
            workers = self.status().workers
        except NoAnswer:
            raise
        except FollowspotError:
            return None
        stages = (stage for worker in workers for stage in worker.stages)
        return {stage.stage: stage for stage in stages if stage.stage in names}

    def stop(self) -> None:
        """End the sources; workers finish the messages in flight."""
        self.ask(StopRun(), ANSWER_TIMEOUT)

    def over(self) -> bool:
        """True if the run has ended; False for a run that does not answer."""
        try:
            return all(worker.phase == "over" for worker in self.status().workers)
        except NoAnswer:
            return False
        except FollowspotError:
            return True


def _has_stepped(source: StageStatus, order: HoldSources) -> bool:
    """True if a source has sent all messages that the order allows."""
    if source.state == "over":
        return True
    return source.state == "paused" and source.hold == order.id and source.time >= order.until
