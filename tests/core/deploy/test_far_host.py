"""A host under an agent: its last words come before its end, and pauses of a listener are not its own."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest

from followspot.deploy import far_host
from followspot.deploy.far_host import FarHost
from followspot.deploy.host import HostLost, HostStatus, RunOrder, WorkerStatus
from followspot.deploy.log.record import LogPage, LogRecord
from followspot.errors import FollowspotError


@dataclass
class Agent:
    """Answers that its run is over, and what was said last."""

    seen: list[tuple[WorkerStatus, ...]] = field(default_factory=list)
    """The workers that the operator's side knew of when it asked for the log."""

    def ask(self, agent: str, verb: str, timeout: float, **data: Any) -> Any:
        if verb == "status":
            return HostStatus((WorkerStatus("left", "over"),), (), logged=0).to_data()
        assert verb == "log"
        self.seen.append(self.host.status().workers)
        return LogPage((LogRecord(1, "error", "the last word"),), 0).to_data()

    def operated(self) -> FarHost:
        self.host = FarHost(self, "pc-left", order=RunOrder("feedc0de", {}))  # type: ignore[arg-type]
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
class Forgetful:
    """An agent that was told by another operator that the run is over, after it was asked once."""

    asked: list[str] = field(default_factory=list)

    def ask(self, agent: str, verb: str, timeout: float, **data: Any) -> Any:
        self.asked.append(verb)
        if verb == "knows":
            return False
        if verb == "status" and self.asked.count("status") == 1:
            return HostStatus((WorkerStatus("left", "running"),), ()).to_data()
        raise FollowspotError("there is no run here")


def test_who_only_looks_on_does_not_begin_a_run_again_that_was_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(far_host, "_FORGOTTEN", 0.3)
    agent = Forgetful()
    host = FarHost(agent, "pc-left", order=RunOrder("feedc0de", {}))  # type: ignore[arg-type]
    host.watch()
    deadline = time.monotonic() + 60.0
    while not host.status().all("over"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    host.leave()
    assert set(agent.asked) == {"status", "knows"}


def test_a_host_is_lost_when_it_is_silent_and_not_when_nobody_listened(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(far_host, "time", SimpleNamespace(monotonic=lambda: now[0]))
    host = Agent().operated()

    def attended(seconds: float) -> None:
        for _ in range(round(5 * seconds)):
            now[0] += 0.2
            host.attend(0.0)

    attended(1.0)
    now[0] += 60.0  # this process was stopped, and had no time to ask
    attended(1.4)
    with pytest.raises(HostLost, match="host pc-left does not answer"):
        attended(1.0)
