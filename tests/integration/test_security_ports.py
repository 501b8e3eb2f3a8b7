"""The hosts that may send on a port and report for its readers: real sessions over TLS, real certificates."""

from __future__ import annotations

from pathlib import Path

from tests.integration.certified import Agent, met, session, wait_for

from followspot.tracking import Frame
from followspot.transport.keys import agent_key, port_key, reader_key
from followspot.transport.zenoh.edge import ZenohReader
from followspot.transport.zenoh.terms import START

PORT = port_key("run", "pc-right", "camera/cam3", "out")


def test_a_camera_host_sends_on_its_own_ports_only(certs: Path, agent: Agent, endpoint: str) -> None:
    own = port_key("run", "pc-left", "camera/cam0", "out")
    foreign = [
        port_key("run", "pc-right", "camera/cam3", "out"),
        port_key("run", "", "track", "out"),
        port_key("run", "pc-right", "credit", "out"),
        port_key("run", "pc-right", "camera/credit", "out"),
        port_key("run", "pc-right", "a/b/credit/pc-left", "out"),
        port_key("run", "pc-right", "camera/cam3", "out/start/5/0"),
        port_key("run", "*", "camera/cam3", "out"),
        agent_key("pc-right"),
        "elsewhere",
    ]
    agent.heard.clear()
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        for key in [*foreign, own]:
            camera.put(key, b"x")
        assert wait_for(lambda: own in agent.heard)
    assert agent.heard == [own]


def test_a_reader_anywhere_reports_credit_to_a_writer_for_its_own_host_alone(
    certs: Path, agent: Agent, endpoint: str
) -> None:
    own = reader_key(PORT, "pc-left") + "/credit/5"
    foreign = [f"{reader_key(PORT, host)}/credit/5" for host in ("", "desk", "pc-right", "*")]
    agent.heard.clear()
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        for key in [*foreign, f"{PORT}/credit/5", own]:
            camera.put(key, b"x")
        assert wait_for(lambda: own in agent.heard)
    assert agent.heard == [own]


def test_no_host_declares_a_reader_of_another_host_alive_or_done(
    certs: Path, agent: Agent, endpoint: str
) -> None:
    """A forged token, or its end, would make the writer not wait at all, or wait for ever."""
    said = ("alive/5/0", "done/5/0/0")
    own = {f"{reader_key(PORT, 'pc-left')}/{word}" for word in said}
    foreign = [f"{reader_key(PORT, host)}/{word}" for host in ("", "desk", "pc-right", "*") for word in said]
    seen: set[str] = set()
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        keys = [*foreign, f"{PORT}/alive/reader/5/0", f"{PORT}/alive/done/5/0/0", *own]
        tokens = [camera.liveliness().declare_token(key) for key in keys]

        def select() -> bool:
            replies = agent.session.liveliness().get(f"{PORT}/**", timeout=1.0)
            seen.update(str(reply.ok.key_expr) for reply in replies if reply.ok is not None)
            return own <= seen

        assert wait_for(select)
        del tokens  # until now they were there
    assert seen == own


def test_only_the_host_of_a_writer_tells_where_its_stream_begins(
    certs: Path, agent: Agent, endpoint: str
) -> None:
    reader = ZenohReader(agent.session, port_key("run", "", "a", "out"), "5", Frame, 4)
    foreign, own = (port_key("run", host, "a", "out/start/5/0") for host in ("", "pc-left"))
    agent.heard.clear()
    with (
        session(certs / "pc-left", connect=endpoint) as camera,
        session(certs / "desk", connect=endpoint) as desk,
    ):
        assert met(camera)
        assert met(desk)
        for key in (foreign, own):
            camera.put(key, START.pack(7, 0, 0, 0))
        assert wait_for(lambda: own in agent.heard)
        assert not reader.poll()
        assert not reader._arrived
        assert reader.position.writer == -1
        desk.put(foreign, START.pack(3, 0, 0, 0))

        def told() -> bool:
            reader.poll()
            return reader.position.writer == 3

        assert wait_for(told)
    reader.close()
