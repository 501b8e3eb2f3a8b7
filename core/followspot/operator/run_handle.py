"""The handle on a run that the command line, the page, tools, notebooks and tests use, and how to get one."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Protocol, TypeVar
from uuid import uuid4

from followspot.control.dispatch import Ask, NoAnswer
from followspot.control.lifecycle import StopRun
from followspot.control.observation import GetLog
from followspot.control.tapping import PlaceTaps, RemoveTaps, Tapping
from followspot.control.unix_socket import served_here
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
from followspot.operator.stepping import step
from followspot.plugins.registry import use_plugin_files
from followspot.transport.zenoh.network import Network

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
        messages; stages may still process them. Raises NoAnswer if no source sends for 60 s.
        """
        return step(self, count, source)

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


@contextmanager
def connected_run(wanted: str | None = None, network: Network | None = None) -> Iterator[RunHandle]:
    """A handle on the run that `wanted` names. The run goes on when the block ends.

    wanted: the graph's name, the beginning of the run's, or the process id of its operator; None names
    the only run; network: leads to agents, asked if no run of this machine has the name; None asks none.
    Raises FollowspotError if there is no such run, or several.
    """
    here = runs_here(wanted)
    if network is None or any(names(run, wanted) for run in here):
        yield _answering(chosen(here, wanted, "on this machine"))
        return
    from followspot.operator.attach import attached, handle_of

    with attached(network, wanted, here) as attachment:
        yield handle_of(attachment, network)


def run_here(wanted: str | None = None) -> RunHandle:
    """The same among the runs of this machine. Raises FollowspotError if there is no such run, or several."""
    return _answering(chosen(runs_here(wanted), wanted, "on this machine"))


def runs_here(wanted: str | None = None) -> list[RunHandle]:
    """The user's runs on this machine, sorted by name; see `served_here`."""
    return [RunHandle(found.run, found.graph, found.ask, found.pid) for found in served_here(wanted)]


class Listed(Protocol):
    """A run in a list of runs. label: how the list shows it; pid: of its operator's process, if known."""

    @property
    def run(self) -> str: ...

    @property
    def graph(self) -> str: ...

    @property
    def pid(self) -> int | None: ...

    @property
    def label(self) -> str: ...


Run = TypeVar("Run", bound=Listed)


def names(run: Listed, wanted: str | None) -> bool:
    """True if `wanted` names this run, as `connected_run` takes it."""
    return wanted is None or wanted in (run.graph, str(run.pid)) or run.run.startswith(wanted)


def chosen(runs: Sequence[Run], wanted: str | None, where: str) -> Run:
    """The run that `wanted` names: the one rule for the run that is meant, here and under agents.

    where: these runs are, for the error message. Raises FollowspotError if there is no such run, or several.
    """
    fitting = [run for run in runs if names(run, wanted)]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        raise FollowspotError(f"there are several runs: {_text(fitting)}; name one by the word in brackets")
    raise FollowspotError(f"there is no run {wanted or ''}".rstrip() + f"; runs {where}: {_text(runs)}")


def _text(runs: Sequence[Listed]) -> str:
    """Runs in one line."""
    return ", ".join(run.label for run in runs) or "none"


def _answering(run: RunHandle) -> RunHandle:
    """The run. Raises NoAnswer if its process does not answer."""
    if not run.graph:
        run.status(timeout=0.5)
    return run
