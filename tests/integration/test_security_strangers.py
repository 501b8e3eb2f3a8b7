"""Peers that cannot connect: without a certificate, with a foreign or expired one, without TLS."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.integration.hosts import free_port

from followspot.errors import FollowspotError
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import config_of

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
def test_an_unknown_peer_is_rejected_logged_and_counted(
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
        "tcp/[fd00::1]:7450",
        "tcp/host:1",
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


@pytest.mark.parametrize(
    "endpoint",
    [
        *("", "x", "tcp", "tcp/", "tcp/x", "tcp/:7450", "tcp/127.0.0.1", "tcp/127.0.0.1:99999", "tcp/a:-1"),
        *("tcp/127.0.0.1:7450:1", "tcp/fd00::1:7450", "tpc/127.0.0.1:7450", "udp/127.0.0.1:7450"),
        *("quic/127.0.0.1:7450", "ws/127.0.0.1:7450", "unixsock-stream//tmp/a.sock", "serial//dev/ttyS0"),
    ],
)
def test_what_is_no_endpoint_is_refused_with_one_that_is(endpoint: str) -> None:
    for network in (Network((endpoint,)), Network(connect=(endpoint,), insecure=True)):
        with pytest.raises(FollowspotError, match=r"no endpoint; write PROTOCOL/HOST:PORT"):
            config_of(network)


@pytest.mark.parametrize("endpoint", ["tcp/[::1]:0", "tcp/127.0.0.1:65535#iface=lo"])
def test_endpoints_of_other_forms_are_accepted(endpoint: str) -> None:
    config_of(Network((endpoint,)))


def test_tls_without_certificates_is_refused_with_the_option_to_give(certs: Path) -> None:
    with pytest.raises(FollowspotError, match="--certificates"):
        config_of(Network(("tls/127.0.0.1:7450",)))
    config_of(Network(("tls/127.0.0.1:7450",), certificates=str(certs / "desk")))
