"""Zenoh sessions: endpoints, peers, and their end."""

from __future__ import annotations

import subprocess
import sys
from contextlib import ExitStack

import pytest
from tests.core.transport.zenoh_pair import Pair, until
from tests.integration.hosts import free_port

from followspot.errors import FollowspotError
from followspot.transport.token import Watermark
from followspot.transport.zenoh.edge import locators, open_session


def test_a_session_on_an_endpoint_that_is_taken_or_nonsense_says_so(pair: Pair) -> None:
    for endpoint in locators(pair.session):
        with pytest.raises(FollowspotError, match="Zenoh cannot use") as told:
            open_session([endpoint])
        assert ".rs:" not in str(told.value)
    with pytest.raises(FollowspotError, match=r"'carrier-pigeon/roof' is no endpoint; .* with tcp or tls"):
        open_session(["carrier-pigeon/roof"])


def test_by_default_only_this_host_is_reached(pair: Pair) -> None:
    assert all(locator.startswith("tcp/127.0.0.1:") for locator in locators(pair.session))


def test_peers_may_start_in_any_order() -> None:
    place = f"tcp/127.0.0.1:{free_port()}"
    with open_session(connect=[place]) as early, open_session([place]):
        until(lambda: len(early.info.peers_zid()) == 1)


def test_peers_of_one_peer_find_each_other() -> None:
    with ExitStack() as sessions:
        hub = sessions.enter_context(open_session())
        spokes = [sessions.enter_context(open_session(connect=locators(hub))) for _ in range(3)]
        until(lambda: all(len(spoke.info.peers_zid()) == 3 for spoke in spokes))


def test_closing_twice_or_after_the_session_does_no_harm(pair: Pair) -> None:
    pair.session.close()  # type: ignore[no-untyped-call]
    pair.writer.send(Watermark(5))
    pair.reader.consumed()
    for _ in range(2):
        pair.writer.close()
        pair.reader.close()


def test_a_process_that_closes_its_edges_exits() -> None:
    script = (
        "from followspot.transport.zenoh.edge import *; from followspot.tracking import Frame;"
        "session = open_session(); writer = ZenohWriter(session, 'k', {'r': ''}, 4);"
        "reader = ZenohReader(session, 'k', 'r', Frame, 4); writer.close(); reader.close(); session.close()"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=30)
