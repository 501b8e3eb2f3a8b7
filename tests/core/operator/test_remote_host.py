"""A remote host: its log arrives before its end, it is resumed after a restart of its agent."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from followspot.control.dispatch import Request, verb
from followspot.control.host import HostLost, HostRefused, HostStatus, RunOrder, WorkerStatus
from followspot.control.lifecycle import EndWorkers, FindRun, PrepareRun, StartRun, StopRun
from followspot.control.move import MoveOrder
from followspot.control.observation import GetHostStatus, GetLog
from followspot.control.swap import ChangeOrder
from followspot.control.zenoh_rpc import InvalidAnswer, RpcClient
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.log.record import LogPage, LogRecord
from followspot.operator.remote import remote_host
from followspot.operator.remote.remote_host import RemoteHost
from followspot.operator.remote.remote_orders import RemoteOrders

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"


@dataclass
class Agent:
    """Answers that its run is over, and with its last log records."""

    seen: list[tuple[WorkerStatus, ...]] = field(default_factory=list)
    """The workers that the operator knew of when it asked for the log."""

    def has_twins(self, agent: str) -> bool:
        return False

    def ask(self, agent: str, request: Request, timeout: float) -> Any:
        if isinstance(request, GetHostStatus):
            return HostStatus((WorkerStatus("left", "over"),), (), logged=0, age_s=0.0)
        assert isinstance(request, GetLog)
        self.seen.append(self.host.status().workers)
        return LogPage((LogRecord(1, "error", "the last word"),), 0)

    def operated(self) -> RemoteHost:
        self.host = RemoteHost(self, "pc-left", order=RunOrder("feedc0de", {}))  # type: ignore[arg-type]
        return self.host


def test_the_log_is_there_before_the_run_is_seen_to_be_over() -> None:
    agent = Agent()
    host = agent.operated()
    host.watch()
    host.leave()
    assert agent.seen == [()]
    assert host.status().all("over")
    assert [record.text for record in host.log.after(-1).records] == ["the last word"]


@dataclass
class Closed:
    """An agent whose run another operator closes after the first request."""

    asked: list[str] = field(default_factory=list)

    def has_twins(self, agent: str) -> bool:
        return False

    def ask(self, agent: str, request: Request, timeout: float) -> Any:
        self.asked.append(verb(type(request)))
        if isinstance(request, FindRun):
            return "unknown"
        if isinstance(request, GetHostStatus) and self.asked.count("get_host_status") == 1:
            return HostStatus((WorkerStatus("left", "running"),), ())
        raise HostRefused("there is no run here")


def test_an_observer_does_not_resume_an_ended_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote_host, "_RESUME_TIMEOUT", 0.3)
    agent = Closed()
    host = RemoteHost(agent, "pc-left", order=RunOrder("feedc0de", {}))  # type: ignore[arg-type]
    host.watch()
    deadline = time.monotonic() + 60.0
    while not host.status().all("over"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    host.leave()
    assert set(agent.asked) == {"get_host_status", "find_run"}
    with pytest.raises(HostLost, match="host pc-left no longer has the run: another operator ended it"):
        host.attend(0.0)


@dataclass
class Twins:
    """Two agents of one name: the second has no run, and is found when the first one has answered."""

    asked: list[str] = field(default_factory=list)

    def has_twins(self, agent: str) -> bool:
        return True

    def ask(self, agent: str, request: Request, timeout: float) -> Any:
        self.asked.append(verb(type(request)))
        if self.asked == ["get_host_status"]:
            return HostStatus((WorkerStatus("left", "running"),), ())
        raise HostRefused("there is no run here")


def test_a_second_agent_of_the_name_is_told_once_and_does_not_get_the_run() -> None:
    agents = Twins()
    host = RemoteHost(agents, "pc-left", order=RunOrder("feedc0de", {}))  # type: ignore[arg-type]
    host.watch()
    deadline = time.monotonic() + 60.0
    while len(agents.asked) < 4:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    host.leave()
    assert set(agents.asked) == {"get_host_status"}
    (told,) = host.log.after(-1).records
    assert told.text.startswith('several agents are named "pc-left" since the run began')


@pytest.mark.parametrize("soon", [False, True])
def test_agents_of_one_name_are_looked_for_now_and_then_while_one_answers(
    soon: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote_host, "_NAME_PERIOD", -1.0 if soon else 1e9)
    agent = Agent()
    host = agent.operated()
    monkeypatch.setattr(agent, "has_twins", lambda name: True)
    host._poll()
    told = [record.text for record in host.log.after(-1).records if "several agents" in record.text]
    assert len(told) == soon


def test_the_age_of_a_status_counts_from_its_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(remote_host, "time", SimpleNamespace(monotonic=lambda: now[0]))
    host = Agent().operated()
    assert host.status().age_s is None  # no answer yet
    host._refresh()
    now[0] += 7.5
    assert host.status().age_s == 7.5


def test_a_silent_host_is_lost_unless_the_operator_was_suspended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(remote_host, "time", SimpleNamespace(monotonic=lambda: now[0]))
    host = Agent().operated()

    def attended(seconds: float) -> None:
        for _ in range(round(5 * seconds)):
            now[0] += 0.2
            host.attend(0.0)

    attended(1.0)
    now[0] += 60.0  # this process was suspended and could not poll
    attended(1.4)
    with pytest.raises(HostLost, match="host pc-left does not answer"):
        attended(1.0)


@dataclass
class Forgetful:
    """An agent that has lost a run.

    refuses: refused verbs with the reasons; cut: verbs whose next answer does not arrive.
    """

    known: str
    refuses: dict[str, str] = field(default_factory=dict)
    cut: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)
    prepared: RunOrder | None = None
    started: bool = False

    def has_twins(self, agent: str) -> bool:
        return False

    def ask(self, agent: str, request: Request, timeout: float) -> Any:
        name = verb(type(request))
        self.asked.append(name)
        answer = self.answer(name, request)
        if name in self.cut:
            self.cut.remove(name)
            raise HostLost("host pc-left does not answer")
        return answer

    def answer(self, name: str, request: Request) -> Any:
        if isinstance(request, FindRun):
            return self.known
        if name in self.refuses:
            raise HostRefused(f"host pc-left: {self.refuses[name]}")
        if isinstance(request, PrepareRun):
            self.known, self.prepared = "here", request.order
            return None
        if self.known != "here":
            raise HostRefused("host pc-left: there is no run 'feedc0de' here")
        if isinstance(request, GetHostStatus):
            return HostStatus((WorkerStatus("left", "running" if self.started else "ready"),), ())
        self.started |= isinstance(request, StartRun)
        return None


def operated(agent: Forgetful, *, restart: bool = True) -> RemoteHost:
    """The agent's host in a run whose worker was restarted twice."""
    host = RemoteHost(agent, "pc-left", order=RunOrder("feedc0de", {}, restart=restart))  # type: ignore[arg-type]
    host._status = HostStatus((WorkerStatus("left", "running", restarts=2),), ())
    return host


@pytest.mark.parametrize(
    ("known", "said"),
    [("unknown", "the agent was restarted"), ("timed out", "the agent had ended the run")],
)
def test_an_agent_that_lost_a_run_resumes_it_and_the_news_say_why(known: str, said: str) -> None:
    agent = Forgetful(known)
    host = operated(agent)
    for _ in range(2):
        host._poll()
    assert agent.prepared is not None
    assert agent.prepared.incarnations["left"] > 2, "what the workers before sent is not taken for theirs"
    assert agent.started
    host._poll()
    assert host.status().all("running")
    assert host.status().news == (f"{said}: its workers start again",)
    assert agent.asked.count("start_run") == 1


@pytest.mark.parametrize("name", ["prepare_run", "start_run"])
def test_a_resumed_run_starts_though_the_link_was_cut_meanwhile(name: str) -> None:
    agent = Forgetful("unknown", cut=[name])
    host = operated(agent)
    for _ in range(3):
        with suppress(HostLost):
            host._poll()
    assert agent.started


def test_a_host_that_cannot_resume_is_lost_with_the_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(remote_host, "time", SimpleNamespace(monotonic=lambda: now[0]))
    agent = Forgetful("unknown", refuses={"prepare_run": "it has no camera"})
    host = operated(agent)

    def attended() -> None:
        for _ in range(20):
            now[0] += 0.2
            host._poll()
            host.attend(0.0)

    with pytest.raises(HostLost, match="host pc-left: it has no camera; it cannot resume the run"):
        attended()
    agent.refuses.clear()
    host._poll()
    host._poll()
    host.attend(0.0)


@pytest.mark.parametrize("ending", ["replay", "stopped"])
def test_a_run_that_ends_or_has_no_restarts_is_not_resumed(ending: str) -> None:
    agent = Forgetful("unknown")
    host = operated(agent, restart=ending != "replay")
    if ending == "stopped":
        host.ask(StopRun())
    host._poll()
    assert agent.prepared is None


def test_a_refused_order_does_not_block_later_ones() -> None:
    agent = Forgetful("here", cut=["end_workers", "stop_run"])
    host = operated(agent)
    host.ask(EndWorkers(workers=("right",)))
    host.ask(StopRun())
    agent.refuses["end_workers"] = "it does not know right"
    host._poll()
    assert agent.asked == [
        "end_workers",
        "stop_run",
        "get_host_status",
        "end_workers",
        "stop_run",
    ]
    host._poll()
    assert agent.asked[5:] == ["get_host_status"]


def test_a_host_that_was_cut_off_is_told_later_that_a_change_came_to_nothing() -> None:
    """Its workers may hold for the change."""
    agent = Forgetful("here", cut=["change_order"])
    host = operated(agent)
    host.ask(ChangeOrder(id="1", step="discard", stages=(), turn=3))
    host._poll()
    assert agent.asked == ["change_order", "get_host_status", "change_order"]
    agent.cut.append("change_order")
    with pytest.raises(HostLost):
        host.ask(ChangeOrder(id="2", step="build", stages=()))


def test_a_host_that_was_cut_off_goes_back_later_after_a_move_that_failed(tmp_path: Path) -> None:
    """The workers of the other hosts are back at their old places already."""
    (tmp_path / "g.yaml").write_text("graph: g\nstages:\n  a: {uses: ticks.count}\n")
    plan = plan_to_data(compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS]))
    agent = Forgetful("here", cut=["move_order", "move_order"])
    host = operated(agent)
    host.ask(MoveOrder(leaving=("left",), back=True))
    host.ask(MoveOrder(plan=plan, back=True))
    assert agent.asked == ["move_order"] * 2
    host._poll()
    assert agent.asked == ["move_order"] * 2 + ["get_host_status"] + ["move_order"] * 2
    agent.cut.append("move_order")
    with pytest.raises(HostLost):
        host.ask(MoveOrder(leaving=("left",)))


def test_an_order_that_an_agent_answers_wrongly_holds_up_no_later_one() -> None:
    asked: list[str] = []
    answers: dict[str, Exception] = {"end_workers": HostLost("no answer"), "stop_run": HostLost("no answer")}

    class Odd(RpcClient):
        """Of an agent that does not answer at first, and gives no valid answer to one kind of order later."""

        def __init__(self) -> None:
            """No session is opened."""

        def ask(self, agent: str, request: Request, timeout: float = 0.0) -> Any:
            asked.append(verb(type(request)))
            if error := answers.get(asked[-1]):
                raise error

    orders = RemoteOrders(Odd(), "pc-left", Path(), RunOrder("feedc0de", {}))
    orders.dispatcher.dispatch(EndWorkers(run="feedc0de", workers=("left",)))
    orders.dispatcher.dispatch(StopRun(run="feedc0de"))
    answers = {"end_workers": InvalidAnswer("pc-left", "end_workers", "no number")}
    asked.clear()
    orders.deliver()
    assert asked == ["end_workers", "stop_run"]
    orders.deliver()
    assert len(asked) == 2
