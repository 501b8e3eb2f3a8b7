"""The requests that an agent answers or rejects: real sessions over TLS on loopback, real certificates."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest
import zenoh
from tests.integration.certified import Agent, Stop, met, session, wait_for
from tests.integration.hosts import free_port

from followspot.control.host import HostLost
from followspot.control.zenoh_rpc import RpcClient
from followspot.errors import FollowspotError, InputError
from followspot.operator import discovery
from followspot.security.authority import create_authority
from followspot.security.request_guard import Asked, envelope
from followspot.transport.keys import agent_key, port_key, request_key
from followspot.transport.zenoh.network import Network, Own


def test_a_request_of_an_operator_is_answered(certs: Path, agent: Agent, endpoint: str) -> None:
    with session(certs / "desk", connect=endpoint) as desk:
        assert met(desk)
        assert agent.ask(desk, request_key("pc-right", "stop", "operator", "desk")) == [{"answer": None}]
    assert agent.stopped.pop() == "r"


def test_a_replayed_request_is_refused_and_counted(certs: Path, agent: Agent, endpoint: str) -> None:
    key = request_key("pc-right", "stop", "operator", "desk")
    with session(certs / "desk", connect=endpoint) as desk:
        assert met(desk)
        assert agent.ask(desk, key)
        once = envelope(Asked.of(key), {"run": "again"})
        for _ in range(2):
            handler = desk.get(key, payload=once, timeout=60.0)
            assert wait_for(lambda: bool(agent.answers._waiting))
            agent.answers.answer()
            list(handler)
    assert agent.stopped.count("again") == 1
    assert agent.answers.guard.refused["replayed"] == 1
    agent.stopped.clear()


def test_a_captured_request_is_rejected_by_another_agent(certs: Path, agent: Agent, endpoint: str) -> None:
    """The left agent captures a request of the operator."""
    captured: list[bytes] = []

    def capture(query: zenoh.Query) -> None:
        assert query.payload is not None
        captured.append(query.payload.to_bytes())
        query.reply(query.key_expr, b'{"answer": null}')

    def asked_on_the_left() -> bool:
        with suppress(HostLost):  # the link between the two may only just be made
            RpcClient(desk, Own("operator", "desk")).ask("pc-left", Stop(run="r"))
        return bool(captured)

    before = agent.answers.guard.refused.get("address", 0)
    with (
        session(certs / "pc-left", listen=f"tls/127.0.0.1:{free_port()}", connect=endpoint) as left,
        session(certs / "desk", connect=endpoint) as desk,
        session(certs / "second", connect=endpoint) as second,
    ):
        left.declare_queryable("followspot/agent/pc-left/**", capture)
        assert met(second)
        assert wait_for(asked_on_the_left)
        for by, name in ((second, "second"), (desk, "desk")):
            answers = agent.hear(by, request_key("pc-right", "stop", "operator", name), captured[0])
            assert [str(answer["refused"]) for answer in answers] == [
                "the request is addressed 'pc-left/stop/operator/desk', "
                f"and came to pc-right as 'pc-right/stop/operator/{name}'"
            ]
        assert agent.hear(second, request_key("pc-right", "stop", "operator", "desk"), captured[0]) == []
        everywhere = Asked("*", "stop", "operator", "desk")
        agent.hear(desk, request_key(*everywhere), envelope(everywhere, {"run": "r"}))
    assert agent.answers.guard.refused["address"] == before + 3
    assert any("refused (address" in line for line in agent.lines)
    assert agent.stopped == []


def test_a_cameras_certificate_cannot_stop_a_run_and_its_attempt_is_logged(
    certs: Path, agent: Agent, endpoint: str
) -> None:
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        answers = agent.ask(camera, request_key("pc-right", "stop", "camera", "pc-left"))
        refused = {"refused": "camera pc-left may not stop; operators may", "reason": "role"}
        assert answers == [refused]
    assert agent.answers.guard.refused["role"] == 1
    assert any("pc-left" in line and "refused (role" in line for line in agent.lines)
    assert agent.stopped == []


@pytest.mark.parametrize(
    "asked_as",
    [("operator", "desk"), ("operator", "pc-left"), ("camera", "pc-right"), ("*", "*"), ("operator", "*")],
)
def test_a_camera_cannot_ask_under_another_name(
    certs: Path, agent: Agent, endpoint: str, asked_as: tuple[str, str]
) -> None:
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        assert agent.ask(camera, request_key("pc-right", "stop", *asked_as)) == []
    assert agent.stopped == []


def test_a_camera_host_cannot_pass_for_another_agent(certs: Path, agent: Agent, endpoint: str) -> None:
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        tokens = [camera.liveliness().declare_token(agent_key(name)) for name in ("desk", "pc-left")]
        seen: set[str] = set()

        def select() -> bool:
            replies = agent.session.liveliness().get(agent_key("*"), timeout=1.0)
            seen.update(str(reply.ok.key_expr) for reply in replies if reply.ok is not None)
            return agent_key("pc-left") in seen

        assert wait_for(select)
        assert agent_key("desk") not in seen
        camera.declare_queryable("followspot/agent/desk/**", lambda query: query.reply(query.key_expr, b"{}"))
        camera.declare_queryable(
            "followspot/agent/pc-left/**", lambda query: query.reply(query.key_expr, b"{}")
        )
        client = RpcClient(agent.session, Own("camera", "pc-right"))

        def answers(name: str) -> bool:
            replies = agent.session.get(request_key(name, "x", "camera", "pc-right"), timeout=1.0)
            return any(reply.ok is not None for reply in replies)

        assert wait_for(lambda: answers("pc-left"))
        assert not answers("desk")
        with pytest.raises(FollowspotError, match="does not answer"):
            client.ask("desk", Stop(), timeout=1.0)
        for token in tokens:
            token.undeclare()  # type: ignore[no-untyped-call]


def test_a_removed_host_connects_but_is_ignored(certs: Path, agent: Agent, endpoint: str) -> None:
    agent.heard.clear()
    with session(certs.parent / "gone", connect=endpoint) as gone:
        assert met(gone)
        gone.put(port_key("run", "gone", "camera", "out"), b"x")
        gone.put(port_key("run", "", "camera", "out"), b"x")
        assert agent.ask(gone, request_key("pc-right", "stop", "operator", "gone")) == []
        with session(certs / "desk", connect=endpoint) as desk:
            assert met(desk)
            desk.put(port_key("run", "", "camera", "out"), b"y")
            assert wait_for(lambda: bool(agent.heard))
    assert len(agent.heard) == 1
    assert agent.stopped == []


def test_an_operator_without_an_agent_reads_what_keeps_them_apart(
    certs: Path, agent: Agent, endpoint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A removed host, and one with a certificate of another authority, would look for an agent in vain."""
    monkeypatch.setattr(discovery, "_TIMEOUT", 0.5)

    def said(folder: Path) -> str:
        network = Network(connect=(endpoint,), certificates=str(folder))
        with discovery.operator_session(network) as opened, pytest.raises(InputError) as caught:
            discovery.await_agents(opened, ["pc-left"], network)
        return str(caught.value)

    assert "that answers: is gone in hosts.json there" in said(certs.parent / "gone")
    foreign = create_authority(tmp_path / "other").add("desk", "operator")
    assert f"{endpoint}: its certificate is not of the authority in {foreign}/ca.pem" in said(foreign)


def test_a_router_passes_on_what_it_has_checked(certs: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    own, foreign = port_key("run", "pc-left", "a", "out"), port_key("run", "pc-right", "a", "out")
    heard: list[str] = []
    with (
        session(certs / "hub", listen=endpoint, routes=True),
        session(certs / "desk", router=endpoint) as desk,
        session(certs / "pc-left", router=endpoint) as camera,
    ):
        subscriber = desk.declare_subscriber(
            "followspot/**", lambda sample: heard.append(str(sample.key_expr))
        )
        assert met(desk)
        assert met(camera)

        def sent() -> bool:
            camera.put(foreign, b"x")
            camera.put(own, b"x")
            return own in heard

        assert wait_for(sent)
        subscriber.undeclare()  # type: ignore[no-untyped-call]
    assert set(heard) == {own}
