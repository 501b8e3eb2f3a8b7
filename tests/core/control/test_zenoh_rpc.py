"""Requests to an agent over a real session, while the clocks of both sides are set."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial

import pytest
import zenoh

from followspot.control import zenoh_rpc
from followspot.control.dispatch import Dispatcher
from followspot.control.host import HostRefused
from followspot.control.lifecycle import FindRun
from followspot.control.zenoh_rpc import RpcClient, RpcServer, agents
from followspot.security.request_clock import RequestClock
from followspot.security.request_guard import WINDOW, RequestGuard
from followspot.transport.zenoh.edge import locators, open_session
from followspot.transport.zenoh.network import UNPROVEN

HOST = "pc-left"
FAR = 10 * WINDOW


class Link:
    """An agent and a client, and by how much the wall clock of each was set, s."""

    def __init__(self, here: zenoh.Session, there: zenoh.Session) -> None:
        self.set_here = self.set_there = 0.0
        self._here, self._there = here, there
        self._client = RpcClient(here, UNPROVEN)
        self._server: RpcServer | None = None

    def start_agent(self) -> None:
        """Start the agent, or start it again."""
        if self._server is not None:
            self._server.close()
        found = Dispatcher("host", {FindRun: lambda _: "here"})
        server = self._server = RpcServer(self._there, HOST, found, wake=lambda: server.answer())
        limit = time.monotonic() + 60.0
        while HOST not in agents(self._here):
            assert time.monotonic() < limit, "the agent is not seen"

    def ask(self) -> str:
        found: str = self._client.ask(HOST, FindRun(run="a"), 30.0)
        return found


@pytest.fixture
def link(monkeypatch: pytest.MonkeyPatch) -> Iterator[Link]:
    with ExitStack() as sessions:
        there = sessions.enter_context(open_session())
        here = sessions.enter_context(open_session(connect=locators(there)))
        made = Link(here, there)
        sender = partial(RequestClock, lambda: time.time() + made.set_here)
        guard = partial(RequestGuard, clock=lambda: time.time() + made.set_there)
        monkeypatch.setattr(zenoh_rpc, "RequestClock", sender)
        monkeypatch.setattr(zenoh_rpc, "RequestGuard", guard)
        made.start_agent()
        yield made


@pytest.mark.parametrize("step", [FAR, -FAR])
def test_an_operator_whose_clock_is_set_is_still_believed(link: Link, step: float) -> None:
    assert link.ask() == "here"
    link.set_here = step
    assert link.ask() == "here"
    link.set_here = 0.0
    assert link.ask() == "here"


def test_an_agent_that_begins_anew_after_both_clocks_were_set_believes_the_operator(link: Link) -> None:
    """It knows only the clock as it is now."""
    assert link.ask() == "here"
    link.set_here = link.set_there = FAR
    assert link.ask() == "here"
    link.start_agent()
    assert link.ask() == "here"
    assert link.ask() == "here"


def test_a_clock_that_was_wrong_from_the_beginning_is_refused(link: Link) -> None:
    link.set_here = FAR
    with pytest.raises(HostRefused, match="set the clocks of both hosts"):
        link.ask()
    link.set_here = 0.0
    assert link.ask() == "here"
