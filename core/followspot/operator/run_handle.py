"""The handle on a run that the command line, the page, tools, notebooks and tests use."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from uuid import uuid4

from followspot.control.dispatch import Ask, NoAnswer
from followspot.control.lifecycle import StopRun
from followspot.control.observation import GetLog
from followspot.control.tapping import PlaceTaps, RemoveTaps, Tapping
from followspot.control.worker_orders import HoldSources
from followspot.errors import FollowspotError
from followspot.graph.override import as_option
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data
from followspot.log.record import LogPage
from followspot.operator.change_outcome import ChangeOutcome, MoveOutcome
from followspot.operator.mark_queue import Mark, Moment, RecorderState
from followspot.operator.mark_request import mark_moment, recorder_state
from followspot.operator.run_requests import (
    ChangeStages,
    ExchangeMarks,
    GetPlan,
    GetRunMetadata,
    GetStatus,
    MoveStages,
    RunMetadata,
)
from followspot.operator.run_status import RunStatus
from followspot.operator.stepping import step
from followspot.plugins.registry import use_plugin_files

ANSWER_TIMEOUT = 10.0
"""Seconds that a run has to answer; a run that is setting up its stages is slow."""
_UNTAP_TIMEOUT = 1.0
"""Seconds that a run has to remove taps; workers also remove a tap whose receiver has gone."""
_CHANGE_TIMEOUT = 120.0
"""Seconds that a change has: new stages are built beside those that run."""


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
        """The plan as it is now; loads the one-file plugins of the run. Raises PluginError."""
        plan = self.outline()
        use_plugin_files(plan.plugin_files)
        return plan

    def outline(self) -> Plan:
        """The plan as it is now, for its names alone: no plugin is loaded."""
        return plan_from_data(self.ask(GetPlan(), ANSWER_TIMEOUT))

    def status(self, timeout: float = ANSWER_TIMEOUT) -> RunStatus:
        """The status of the run now. timeout: seconds after which NoAnswer is raised."""
        found: RunStatus = self.ask(GetStatus(), timeout)
        return found

    def log(self, after: int = -1) -> LogPage:
        """The log records after the record of this number."""
        found: LogPage = self.ask(GetLog(after=after), ANSWER_TIMEOUT)
        return found

    def metadata(self) -> RunMetadata:
        """The output folder of the run, the network that leads to its hosts, and the files of its graph."""
        found: RunMetadata = self.ask(GetRunMetadata(), ANSWER_TIMEOUT)
        return found

    def set(self, parameter: str, value: Any) -> ChangeOutcome:
        """Set a parameter during the run: ``set("color.similarity", 0.85)``."""
        return self.change([as_option(parameter, value)])

    def swap(self, stage: str, uses: str, *, fresh: bool = False) -> ChangeOutcome:
        """Replace a stage during the run by another plugin stage: ``swap("fuse", "balls.mean")``."""
        return self.change([f"{stage}={uses}"], fresh=fresh)

    def change(self, words: Sequence[str], *, folder: Path = Path(), fresh: bool = False) -> ChangeOutcome:
        """Make several swaps (`fuse=balls.mean`) and settings (`color.similarity=0.7`), all or none.

        Replacements are built beside the running stages and take over between two firings. They restore the
        state of the old stages if both support it, unless `fresh`. folder: base of relative paths.
        """
        request = ChangeStages(words=tuple(words), folder=folder.absolute(), fresh=fresh)
        found: ChangeOutcome = self.ask(request, _CHANGE_TIMEOUT)
        return found

    def move(self, stages: Sequence[str], place: str) -> MoveOutcome:
        """Move stages of a live run to another worker, or to a host that the run can reach.

        Workers whose stages or kinds of edges change restart from the state of their stages. Messages in
        flight to and from them are lost and counted.
        """
        found: MoveOutcome = self.ask(MoveStages(stages=tuple(stages), place=place), _CHANGE_TIMEOUT)
        return found

    def tap(self, taps: Sequence[Tapping]) -> None:
        """Tap ports: their messages also go to the given sinks."""
        self.ask(PlaceTaps(taps=tuple(taps)), ANSWER_TIMEOUT)

    def untap(self, taps: Sequence[Tapping]) -> None:
        """Remove these taps, also from workers that restart later; a run that has ended has none."""
        with suppress(FollowspotError):
            self.ask(RemoveTaps(taps=tuple(taps)), _UNTAP_TIMEOUT)

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
        messages; stages may still process them. Raises FollowspotError if another command pauses, resumes or
        steps the run meanwhile, NoAnswer if no source sends for 60 s.
        """
        return step(self, count, source)

    def mark(self, *, after: float = 5.0, note: str = "", wait: bool = False) -> Moment:
        """Save what the flight recorder holds, and the `after` s to come, into a file; overlapping marks
        share one.

        wait: return when the file is complete, not as soon as its name is known. Raises FollowspotError if
        the run has no flight recorder (`--keep`), or the disk does not take the file.
        """
        return mark_moment(self.ask, after, note, wait=wait)

    def kept(self) -> RecorderState | None:
        """The state of the flight recorder, with the files of marks; None if the run has none."""
        return recorder_state(self.ask)

    def exchange_marks(self, kept: RecorderState | None, taken: int) -> tuple[Mark, ...]:
        """For flight recorders: tell the run what is held; the marks after the number `taken`.

        kept: None if the recorder has ended.
        """
        found: tuple[Mark, ...] = self.ask(ExchangeMarks(kept=kept, taken=taken), ANSWER_TIMEOUT)
        return found

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
