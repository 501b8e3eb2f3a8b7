"""Who gets in and what they may do: real sessions over TLS on loopback, real certificates."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import ClassVar

import pytest
import zenoh
from tests.integration.hosts import free_port

from followspot.control.dispatch import Dispatcher, Role, RunRequest
from followspot.control.host import HostLost
from followspot.control.zenoh_rpc import RpcClient, RpcServer
from followspot.errors import FollowspotError
from followspot.security.authority import Authority, create_authority
from followspot.security.request_guard import Asked, seal
from followspot.tracking import Frame
from followspot.transport.keys import agent_key, port_key, reader_key, request_key
from followspot.transport.zenoh.edge import ZenohReader
from followspot.transport.zenoh.network import Network, Own
from followspot.transport.zenoh.session import config_of, connected
from followspot.transport.zenoh.terms import START

HOSTS = {"desk": "operator", "second": "operator", "pc-left": "camera", "pc-right": "camera", "hub": "router"}


@pytest.fixture(scope="module")
def certs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certs") / "ours"
    authority = create_authority(folder)
    for name, role in HOSTS.items():
        authority.add(name, role)  # type: ignore[arg-type]
    authority.add("gone", "operator")
    lost = (folder / "gone").rename(folder.parent / "gone")
    authority.remove("gone")
    assert lost.exists()
    yesterday = datetime.now(UTC) - timedelta(days=2)
    Authority(folder, yesterday).add("late", "operator", days=1)
    foreign = create_authority(folder.parent / "foreign")
    for name, role in HOSTS.items():
        foreign.add(name, role)  # type: ignore[arg-type]
    return folder


@contextmanager
def session(
    folder: Path, *, listen: str = "", connect: str = "", router: str = "", routes: bool = False
) -> Iterator[zenoh.Session]:
    network = Network((listen,) if listen else (), (connect,) if connect else (), str(folder), router=router)
    opened = connected(network, routes=routes)
    try:
        yield opened
    finally:
        opened.close()  # type: ignore[no-untyped-call]


def wait_for(condition: Callable[[], bool], seconds: float = 15.0) -> bool:
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


def met(session: zenoh.Session) -> bool:
    return wait_for(lambda: bool(session.info.links()))


class Stop(RunRequest):
    roles: ClassVar[tuple[Role, ...]] = ("host",)


class Agent:
    """An agent's ears: what it is asked, what it refuses, and what arrives on the ports it reads."""

    def __init__(self, session: zenoh.Session, name: str) -> None:
        self.stopped: list[str] = []
        self.heard: list[str] = []
        self.lines: list[str] = []
        self.session = session
        stop = Dispatcher("host", {Stop: lambda request: self.stopped.append(request.run)})
        self.answers = RpcServer(session, name, stop, lambda: None, self.lines.append)
        session.declare_subscriber("followspot/**", lambda sample: self.heard.append(str(sample.key_expr)))

    def ask(self, by: zenoh.Session, key: str) -> list[dict[str, object]]:
        """The answers to a request under this key, from whoever answers."""
        return self.hear(by, key, seal(Asked.of(key), {"run": "r"}))

    def hear(self, by: zenoh.Session, key: str, payload: bytes) -> list[dict[str, object]]:
        """The answers to this very request, under this key."""
        handler = by.get(key, payload=payload, timeout=2.0)
        replies: list[dict[str, object]] = []
        for _ in range(100):
            self.answers.answer()
            try:
                while (reply := handler.try_recv()) is not None:
                    if reply.ok is not None:
                        replies.append(json.loads(reply.ok.payload.to_bytes()))
            except zenoh.ZError:  # all replies are here
                break
            time.sleep(0.03)
        return replies


@pytest.fixture(scope="module")
def endpoint() -> str:
    return f"tls/127.0.0.1:{free_port()}"


@pytest.fixture(scope="module")
def agent(certs: Path, endpoint: str) -> Iterator[Agent]:
    with session(certs / "pc-right", listen=endpoint) as opened:
        agent = Agent(opened, "pc-right")
        yield agent
        agent.answers.close()


def test_an_operator_is_heard(certs: Path, agent: Agent, endpoint: str) -> None:
    with session(certs / "desk", connect=endpoint) as desk:
        assert met(desk)
        assert agent.ask(desk, request_key("pc-right", "stop", "operator", "desk")) == [{"answer": None}]
    assert agent.stopped.pop() == "r"


def test_a_replayed_request_is_refused_and_counted(certs: Path, agent: Agent, endpoint: str) -> None:
    key = request_key("pc-right", "stop", "operator", "desk")
    with session(certs / "desk", connect=endpoint) as desk:
        assert met(desk)
        assert agent.ask(desk, key)
        once = seal(Asked.of(key), {"run": "again"})
        for _ in range(2):
            handler = desk.get(key, payload=once, timeout=2.0)
            assert wait_for(lambda: bool(agent.answers._waiting))
            agent.answers.answer()
            list(handler)
    assert agent.stopped.count("again") == 1
    assert agent.answers.guard.refused["replayed"] == 1
    agent.stopped.clear()


def test_a_captured_request_is_refused_by_another_agent_whoever_passes_it_on(
    certs: Path, agent: Agent, endpoint: str
) -> None:
    """The agent on the left keeps what the desk asked of it."""
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
        agent.hear(desk, request_key(*everywhere), seal(everywhere, {"run": "r"}))
    assert agent.answers.guard.refused["address"] == before + 3
    assert any("refused (address" in line for line in agent.lines)
    assert agent.stopped == []


def test_a_cameras_certificate_cannot_stop_a_run_and_its_attempt_is_logged(
    certs: Path, agent: Agent, endpoint: str
) -> None:
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        answers = agent.ask(camera, request_key("pc-right", "stop", "camera", "pc-left"))
        assert answers == [{"refused": "camera pc-left may not stop; operators may"}]
    assert agent.answers.guard.refused["role"] == 1
    assert any("pc-left" in line and "refused (role" in line for line in agent.lines)
    assert agent.stopped == []


@pytest.mark.parametrize(
    "asked_as",
    [("operator", "desk"), ("operator", "pc-left"), ("camera", "pc-right"), ("*", "*"), ("operator", "*")],
)
def test_a_camera_cannot_ask_as_somebody_else(
    certs: Path, agent: Agent, endpoint: str, asked_as: tuple[str, str]
) -> None:
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        assert agent.ask(camera, request_key("pc-right", "stop", *asked_as)) == []
    assert agent.stopped == []


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


PORT = port_key("run", "pc-right", "camera/cam3", "out")


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


def test_no_host_declares_a_reader_on_another_host_to_be_there_or_done(
    certs: Path, agent: Agent, endpoint: str
) -> None:
    """Its token, or the end of it, would let the writer wait for nobody, or for ever."""
    said = ("alive/5/0", "done/5/0/0")
    own = {f"{reader_key(PORT, 'pc-left')}/{word}" for word in said}
    foreign = [f"{reader_key(PORT, host)}/{word}" for host in ("", "desk", "pc-right", "*") for word in said]
    seen: set[str] = set()
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        keys = [*foreign, f"{PORT}/alive/reader/5/0", f"{PORT}/alive/done/5/0/0", *own]
        tokens = [camera.liveliness().declare_token(key) for key in keys]

        def look() -> bool:
            replies = agent.session.liveliness().get(f"{PORT}/**", timeout=1.0)
            seen.update(str(reply.ok.key_expr) for reply in replies if reply.ok is not None)
            return own <= seen

        assert wait_for(look)
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
        assert reader._writer == -1
        desk.put(foreign, START.pack(3, 0, 0, 0))

        def told() -> bool:
            reader.poll()
            return reader._writer == 3

        assert wait_for(told)
    reader.close()


def test_a_camera_host_cannot_pass_for_another_agent(certs: Path, agent: Agent, endpoint: str) -> None:
    with session(certs / "pc-left", connect=endpoint) as camera:
        assert met(camera)
        tokens = [camera.liveliness().declare_token(agent_key(name)) for name in ("desk", "pc-left")]
        seen: set[str] = set()

        def look() -> bool:
            replies = agent.session.liveliness().get(agent_key("*"), timeout=1.0)
            seen.update(str(reply.ok.key_expr) for reply in replies if reply.ok is not None)
            return agent_key("pc-left") in seen

        assert wait_for(look)
        assert agent_key("desk") not in seen
        camera.declare_queryable("followspot/agent/desk/**", lambda query: query.reply(query.key_expr, b"{}"))
        camera.declare_queryable(
            "followspot/agent/pc-left/**", lambda query: query.reply(query.key_expr, b"{}")
        )
        asker = RpcClient(agent.session, Own("camera", "pc-right"))

        def answers(name: str) -> bool:
            replies = agent.session.get(request_key(name, "x", "camera", "pc-right"), timeout=1.0)
            return any(reply.ok is not None for reply in replies)

        assert wait_for(lambda: answers("pc-left"))
        assert not answers("desk")
        with pytest.raises(FollowspotError, match="does not answer"):
            asker.ask("desk", Stop(), timeout=1.0)
        for token in tokens:
            token.undeclare()  # type: ignore[no-untyped-call]


def test_a_host_that_was_removed_connects_and_is_heard_by_nobody(
    certs: Path, agent: Agent, endpoint: str
) -> None:
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


KNOCK = """
import json, sys, zenoh
settings = json.loads(sys.argv[1])
config = zenoh.Config()
for key, value in settings.items():
    config.insert_json5(key, json.dumps(value))
try:
    session = zenoh.open(config)
except zenoh.ZError:
    print("refused")
else:
    print("links", len(session.info.links()))
    session.close()
"""

LISTEN = """
import sys
from contextlib import closing
from followspot.security.rejected_peers import RejectedPeers
from followspot.tracking import Frame
from followspot.transport.zenoh.edge import ZenohReader
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import connected
network = Network((sys.argv[1],), (), sys.argv[2])
with RejectedPeers(lambda line: print(line, file=sys.stderr)), closing(connected(network)):
    print("listening", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def knocked(certs: Path) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    words = [sys.executable, "-c", LISTEN, endpoint, str(certs / "pc-right")]
    process = subprocess.Popen(
        words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "listening\n"
    yield endpoint, process
    process.kill()
    process.wait()


@pytest.mark.parametrize(
    ("stranger", "said", "counted"),
    [
        ("without a certificate", "peer sent no certificates", "certificate"),
        ("of a foreign authority", "invalid peer certificate", "certificate"),
        ("with an expired certificate", "certificate expired", "certificate"),
        ("without TLS", "InvalidContentType", "tls"),
        ("that was removed", "not on the list of hosts", "unlisted"),
    ],
)
def test_a_stranger_does_not_get_in_and_the_attempt_is_logged_and_counted(
    certs: Path, knocked: tuple[str, subprocess.Popen[str]], stranger: str, said: str, counted: str
) -> None:
    endpoint, process = knocked
    shown = {
        "of a foreign authority": certs.parent / "foreign" / "desk",
        "with an expired certificate": certs / "late",
        "that was removed": certs.parent / "gone",
    }
    tls: dict[str, object] = {"root_ca_certificate": str(certs / "desk" / "ca.pem")}
    if stranger in shown:
        tls |= {
            "enable_mtls": True,
            "connect_certificate": str(shown[stranger] / "cert.pem"),
            "connect_private_key": str(shown[stranger] / "key.pem"),
        }
    settings = {
        "mode": "client",
        "connect/endpoints": [endpoint.replace("tls/", "tcp/") if stranger == "without TLS" else endpoint],
        "connect/timeout_ms": 1500,
        "transport/link/tls": tls,
    }
    knock = subprocess.run(
        [sys.executable, "-c", KNOCK, json.dumps(settings)], capture_output=True, text=True, check=True
    )
    assert knock.stdout.strip() in ("refused", "links 0") or counted == "unlisted"
    log, _ = process.communicate("", timeout=30)
    assert said in log
    attempts = log.count(f"refused ({counted}, ")
    assert log.splitlines()[-1] == f"peers refused: {attempts} {counted}"


def test_nothing_but_loopback_is_opened_without_certificates_or_consent() -> None:
    for endpoint in (
        "tcp/0.0.0.0:7450",
        "tcp/192.168.0.7:7450",
        "udp/[fd00::1]:7450",
        "tcp/host:1",
        "quic/1.2.3.4:5",
    ):
        with pytest.raises(FollowspotError, match="open to other hosts without protection"):
            config_of(Network((endpoint,)))
        with pytest.raises(FollowspotError, match="open to other hosts without protection"):
            config_of(Network(connect=(endpoint,)))
        config_of(Network((endpoint,), insecure=True))
    with pytest.raises(FollowspotError, match="local network"):
        config_of(Network(discover=True))
    config_of(Network(discover=True, insecure=True))
    for endpoint in ("tcp/127.0.0.1:0", "tcp/[::1]:0", "tcp/localhost:7450"):
        config_of(Network((endpoint,)))


def test_tls_without_certificates_is_refused_with_the_option_to_give(certs: Path) -> None:
    with pytest.raises(FollowspotError, match="--certificates"):
        config_of(Network(("tls/127.0.0.1:7450",)))
    config_of(Network(("tls/127.0.0.1:7450",), certificates=str(certs / "desk")))
