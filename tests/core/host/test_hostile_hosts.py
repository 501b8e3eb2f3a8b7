"""Invalid answers of an agent, over a real session.

The operator keeps polling, says why an answer is invalid, and takes the next valid one.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
import zenoh
from zenoh.handlers import Callback

from followspot.control.dispatch import answer_from_wire, answer_to_wire
from followspot.control.host import HostLost, HostStatus, RunOrder, WorkerStatus
from followspot.control.observation import GetHostStatus, GetLog
from followspot.control.zenoh_rpc import MAX_ANSWER, RpcClient, agents
from followspot.errors import FollowspotError
from followspot.host.clocks.host import HostClock
from followspot.log.record import LogPage, LogRecord
from followspot.messages import MAX_TIME
from followspot.operator.attach import find_runs
from followspot.operator.remote.remote_host import RemoteHost
from followspot.transport.keys import agent_key, request_key
from followspot.transport.zenoh.edge import locators, open_session
from followspot.transport.zenoh.network import UNPROVEN, Network
from followspot.valid_values.numbers import MAX_EXACT

HOST = "pc-left"
GOOD = answer_to_wire(
    GetHostStatus, HostStatus((WorkerStatus("left", "running", 5, 7),), (1, 1, 0), logged=0)
)
PAGE = answer_to_wire(GetLog, LogPage((LogRecord(1, "info", "well"),), 0))


class Agent:
    """Answers each verb with the bytes in `says`."""

    def __init__(self, session: zenoh.Session) -> None:
        self.says: dict[str, bytes] = {}
        self.asked: dict[str, int] = {}
        self.workers = self.named = 0
        """Number of ended workers with new names in each status, and number of names so far."""
        key = request_key(HOST, "*", "*", "*")
        self._declared = [
            session.declare_queryable(key, Callback(self._answer, indirect=False)),
            session.liveliness().declare_token(agent_key(HOST)),
        ]

    def say(self, verb: str, data: Any) -> None:
        self.says[verb] = json.dumps({"answer": data}).encode()

    def _answer(self, query: zenoh.Query) -> None:
        verb = str(query.key_expr).split("/")[-3]
        self.asked[verb] = self.asked.get(verb, 0) + 1
        if verb == "get_host_status" and self.workers:
            self.named += self.workers
            workers = [{"name": f"w{self.named + n}", "phase": "over"} for n in range(self.workers)]
            self.say("get_host_status", {**GOOD, "workers": workers})
        query.reply(query.key_expr, self.says.get(verb, b'{"answer": null}'))


@pytest.fixture
def agent() -> Iterator[tuple[Agent, RpcClient]]:
    with ExitStack() as sessions:
        there = sessions.enter_context(open_session())
        here = sessions.enter_context(open_session(connect=locators(there)))
        made = Agent(there)
        made.say("get_host_status", GOOD)
        made.say("get_log", PAGE)
        until(lambda: bool(list(here.liveliness().get(agent_key(HOST), timeout=1.0))))
        yield made, RpcClient(here, UNPROVEN)


def until(condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < limit, "it never happened"
        time.sleep(0.01)


NO_ANSWERS = {
    "nothing": b"",
    "no JSON": b"\xff\xfe",
    "a number": b"5",
    "a list": b"[]",
    "empty": b"{}",
    "deep": b"[" * 100_000,
    "long": b'{"answer": "' + b"a" * MAX_ANSWER + b'"}',
    "a huge number": b'{"answer": ' + b"9" * 5000 + b"}",
}
NO_STATUS: dict[str, dict[str, Any]] = {
    "a count of 2^63": {"counts": [2**63, 0, 0]},
    "a count beyond JSON": {"counts": [MAX_EXACT + 1, 0, 0]},
    "a negative count": {"counts": [-1, 0, 0]},
    "a count that is no number": {"counts": [float("nan"), 0, 0]},
    "an infinite age": {"age_s": float("inf")},
    "a log without end": {"logged": 2**63},
    "workers that are none": {"workers": [5]},
    "a capture time of 2^63": {"workers": [{"name": "a", "phase": "running", "time": 2**63}]},
    "a restart too many": {"workers": [{"name": "a", "phase": "running", "restarts": 2**63}]},
    "an offset of 1e308": {"clock": {"reference": "x", "offset_ms": 1e308}},
}


def watched(agent: Agent, client: RpcClient) -> RemoteHost:
    host = RemoteHost(client, HOST, order=RunOrder("feedc0de", {}))
    host.watch()
    assert host.status().workers[0].fired == 5
    return host


def believed_again(agent: Agent, host: RemoteHost) -> None:
    """Wait until the polling thread takes the next valid answer."""
    agent.say("get_host_status", {**GOOD, "out": "again"})
    until(lambda: host.status().out == "again")
    until(lambda: (host.attend(0.0), True)[1])
    host.leave()


@pytest.mark.parametrize("says", NO_ANSWERS.values(), ids=NO_ANSWERS)
def test_an_invalid_answer_is_survived_and_the_next_valid_one_taken(
    agent: tuple[Agent, RpcClient], says: bytes
) -> None:
    there, client = agent
    host = watched(there, client)
    there.says["get_host_status"] = says
    with pytest.raises(FollowspotError, match=HOST):
        client.ask(HOST, GetHostStatus(run="feedc0de"))
    asked = there.asked["get_host_status"]
    until(lambda: there.asked["get_host_status"] > asked + 3)
    believed_again(there, host)


@pytest.mark.parametrize("change", NO_STATUS.values(), ids=NO_STATUS)
def test_an_invalid_status_is_rejected(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(change))):
        answer_from_wire(GetHostStatus, {**GOOD, **change})


def test_the_fault_of_a_status_is_reported_and_the_next_valid_one_taken(
    agent: tuple[Agent, RpcClient],
) -> None:
    there, client = agent
    change = NO_STATUS["a count of 2^63"]
    host = watched(there, client)
    there.say("get_host_status", {**GOOD, **change})
    refused: list[str] = []

    def lost() -> bool:
        try:
            host.attend(0.05)
        except HostLost as error:
            refused.append(str(error))
        return bool(refused)

    until(lost)
    assert f"its last answer was invalid: {next(iter(change))}" in refused[0]
    assert host.status().workers[0].fired == 5, "the last good one stays"
    believed_again(there, host)


@pytest.mark.parametrize(
    "page", [{"last": 2**63}, {"records": [{"time": 2**63, "level": "info", "text": ""}]}, {"records": 5}]
)
def test_an_invalid_page_of_a_log_is_rejected(agent: tuple[Agent, RpcClient], page: Any) -> None:
    there, client = agent
    host = watched(there, client)
    there.say("get_log", {**PAGE, **page})
    there.say("get_host_status", {**GOOD, "logged": 7})
    asked = there.asked["get_log"]
    until(lambda: there.asked["get_log"] > asked + 2)
    assert len(host.log.after(-1).records) == 1
    there.say("get_log", {"records": [], "last": 7})
    believed_again(there, host)


def test_ended_workers_that_are_no_longer_listed_use_bounded_memory(
    agent: tuple[Agent, RpcClient], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("followspot.operator.remote.remote_host._POLL_PERIOD", 0.0)
    monkeypatch.setattr("followspot.operator.remote.remote_host._MAX_ENDED_WORKERS", 50)
    there, client = agent
    host = watched(there, client)
    there.workers = 20
    until(lambda: there.named > 400)
    assert len(host.status().workers) <= 70
    host.leave()


@pytest.mark.parametrize("verb", ["captured", "steady"])
@pytest.mark.parametrize("reads", [2**63, MAX_TIME, -1, 1e308, float("nan"), "5", None, True, 10**400])
def test_an_invalid_clock_reading_is_rejected(
    agent: tuple[Agent, RpcClient], verb: str, reads: object
) -> None:
    there, client = agent
    there.say("read_clock", {"captured": time.time_ns(), "steady": time.monotonic_ns(), verb: reads})
    clock = HostClock(client)
    clock.follow(HOST)
    clock.close()
    assert there.asked["read_clock"] == 1
    assert clock.correction()[:2] == (0, 0)
    assert clock.status().warning, "the operator is told"


@pytest.mark.parametrize("runs", [5, [5], [{"run": 5}], [{}], {"run": "a"}])
def test_an_invalid_listing_of_runs_is_an_error_that_names_the_host(
    agent: tuple[Agent, RpcClient], runs: object
) -> None:
    there, client = agent
    there.say("list_runs", runs)
    with pytest.raises(FollowspotError, match=f"host {HOST}: its answer to list_runs is invalid"):
        find_runs(client, Network(), print)


def test_a_listing_goes_on_without_an_agent_that_does_not_answer(agent: tuple[Agent, RpcClient]) -> None:
    there, client = agent
    there.say("list_runs", [{"run": "feedc0de", "graph": "show", "over": False}])
    token = client.session.liveliness().declare_token(agent_key("aside"))
    until(lambda: len(agents(client.session)) == 2)
    gaps: list[str] = []
    assert [run.run for run in find_runs(client, Network(), gaps.append)] == ["feedc0de"]
    assert gaps == ["host aside does not answer"]
    token.undeclare()  # type: ignore[no-untyped-call]
