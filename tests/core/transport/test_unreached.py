"""An endpoint that cannot be reached, or that refuses, says why: which file, which remedy."""

from __future__ import annotations

import socket
import ssl
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from tests.integration.hosts import free_port

from followspot.security.authority import Authority, create_authority
from followspot.transport.unreached import Reached, reach, unreached
from followspot.transport.zenoh import session
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import NoRouter

NOW = datetime.now(UTC)


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    authority = create_authority(tmp_path / "certs", NOW - timedelta(days=30))
    authority.add("desk", "operator", days=1000)
    return authority


@contextmanager
def listening(folder: Path, address: str = "127.0.0.1") -> Iterator[str]:
    """An endpoint that shows the certificate in a folder, and asks for one of its authority."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / "cert.pem", folder / "key.pem")
    context.load_verify_locations(folder / "ca.pem")
    context.verify_mode = ssl.CERT_REQUIRED

    def serve() -> None:
        with suppress(OSError):
            link, _ = listener.accept()
            with context.wrap_socket(link, server_side=True) as secured:
                secured.recv(1)

    with socket.create_server((address, 0)) as listener:
        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f"tls/{address}:{listener.getsockname()[1]}"
        thread.join(10)


@contextmanager
def greeting(said: bytes) -> Iterator[str]:
    """An endpoint of a program that says this to each newcomer, and hangs up."""

    def serve() -> None:
        link, _ = listener.accept()
        with link:
            link.sendall(said)
            link.recv(1)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f"tcp/127.0.0.1:{listener.getsockname()[1]}"
        thread.join(10)


@contextmanager
def zenoh_at(endpoint: str, folder: Path | str = "") -> Iterator[tuple[str, str]]:
    """An endpoint where a Zenoh session listens, and the id of the session."""
    listener = session.connected(Network((endpoint,), certificates=str(folder)))
    try:
        yield endpoint, str(listener.zid())
    finally:
        session.close_session(listener)


def fault(folder: Path, own: Path, address: str = "127.0.0.1") -> str:
    with listening(folder, address) as endpoint:
        said = unreached([endpoint], str(own))
    return said.removeprefix(f"{endpoint}: ")


def test_nothing_is_said_of_an_end_that_takes_the_certificate(authority: Authority) -> None:
    left, desk = authority.add("pc-left", "camera", days=1000), authority.folder / "desk"
    with zenoh_at(f"tls/127.0.0.1:{free_port()}", left) as (endpoint, zid):
        assert reach(endpoint, str(desk)) == Reached("", zid)


def test_what_listens_but_is_no_agent_or_router_is_told(authority: Authority) -> None:
    left, desk = authority.add("pc-left", "camera", days=1000), authority.folder / "desk"
    with zenoh_at(f"tls/127.0.0.1:{free_port()}", left) as (endpoint, _):
        assert "no agent or router" in reach(endpoint.replace("tls/", "tcp/"), "").fault, "it wants TLS"
    with zenoh_at(f"tcp/127.0.0.1:{free_port()}") as (endpoint, zid):
        assert reach(endpoint, "") == Reached("", zid)
        assert "another protocol (tcp/, tls/)?" in reach(endpoint.replace("tcp/", "tls/"), str(desk)).fault
    with greeting(b"SSH-2.0-OpenSSH_9.6\r\n") as endpoint:
        assert "no agent or router: is this its port" in reach(endpoint, "").fault
    with greeting(b"") as endpoint:
        assert "no agent or router" in reach(endpoint, "").fault


def test_what_listens_and_says_nothing_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("followspot.transport.unreached._TIMEOUT", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        said = reach(f"tcp/127.0.0.1:{silent.getsockname()[1]}", "").fault
    assert said.startswith("what listens there does not answer")


def test_each_fault_of_the_certificate_there_has_its_remedy(authority: Authority, tmp_path: Path) -> None:
    desk = authority.folder / "desk"
    ended = authority.add("ended", "camera", days=1)
    assert "its certificate has expired, or the clock here is wrong" in fault(ended, desk)
    early = Authority(authority.folder, NOW + timedelta(days=2)).add("early", "camera")
    assert "its certificate is not valid yet: set the clock here" in fault(early, desk)
    elsewhere = authority.add("elsewhere", "camera", ["10.0.0.7"], days=1000)
    assert "certs host NAME --renew --address 127.0.0.2" in fault(elsewhere, desk, "127.0.0.2")
    foreign = create_authority(tmp_path / "other", NOW).add("pc-left", "camera")
    assert f"its certificate is not of the authority in {desk}/ca.pem" in fault(foreign, desk)


def test_an_end_that_does_not_take_the_certificate_of_this_host_is_told(authority: Authority) -> None:
    left, own = authority.add("pc-left", "camera", days=1000), authority.add("own", "operator", days=1)
    assert f"it does not take the certificate in {own}" in fault(left, own)


def test_an_end_where_nothing_listens_is_told_whatever_its_protocol() -> None:
    port = free_port()
    endpoints = [f"tcp/127.0.0.1:{port}", f"tls/[::1]:{port}", "udp/127.0.0.1:1"]
    said = unreached(endpoints, "")
    assert said == f"tcp/127.0.0.1:{port}: nothing listens there; tls/[::1]:{port}: nothing listens there"


def test_a_router_that_is_not_there_is_told_and_not_awaited_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(session._SETTINGS, "connect/timeout_ms", 200)
    at = f"tcp/127.0.0.1:{free_port()}"
    why = f"no router answers at {at}: nothing listens there"
    with pytest.raises(NoRouter, match=why):
        session.connected(Network(router=at))
    asked: list[bool] = []
    told: list[str] = []

    def wanted() -> bool:
        asked.append(True)
        return len(asked) < 4

    with pytest.raises(NoRouter, match=why):
        session.connected_in_the_end(Network(router=at), told.append, wanted)
    assert told == [f"{why}; waiting for it"], "a reason is told once"
