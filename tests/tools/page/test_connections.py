"""Many connections to the page, and hostile bytes on them: every browser that asks is served."""

from __future__ import annotations

import json
import os
import re
import socket
import struct
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest
from tests.tools.page.bundled import bundle
from tests.tools.page.page_socket import UPGRADE, things
from tests.tools.page.served import Shown, served
from websockets.exceptions import ConnectionClosedError

from followspot_page.connections import MAX_FRAGMENTS, MAX_WAITING
from followspot_page.http.routes import MAX_HEARD

CROWD = 300
MASK = b"\1\2\3\4"
TEXT, CONTINUED, BINARY, CLOSE, PING = 1, 0, 2, 8, 9


@pytest.fixture(scope="module")
def crowded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Shown, Path]]:
    """A page, and the file into which its process complains."""
    bundle()
    folder = tmp_path_factory.mktemp("crowd")
    complaints = folder / "complaints"
    with complaints.open("wb") as file, ExitStack() as stack:
        with redirected(file.fileno()):
            made = stack.enter_context(served(folder))
        yield made, complaints


@contextmanager
def redirected(to: int) -> Iterator[None]:
    """Who is started in the block complains there."""
    before = os.dup(2)
    os.dup2(to, 2)
    try:
        yield
    finally:
        os.dup2(before, 2)
        os.close(before)


@pytest.fixture
def page(crowded: tuple[Shown, Path]) -> Iterator[Shown]:
    """The page, whose process has said nothing when the test ends."""
    made, complaints = crowded
    yield made
    assert complaints.read_text() == ""


def refused(page: Shown) -> dict[str, int]:
    """By reason, as the metrics tell it."""
    text = page.get("metrics")[1]
    found = re.findall(r'^followspot_page_refused_total\{reason="([^"]+)"\} (\d+)$', text, re.MULTILINE)
    return {reason: int(count) for reason, count in found}


@contextmanager
def refusing(page: Shown, reason: str, least: int = 1) -> Iterator[None]:
    """So many more are refused for this reason than before the block."""
    before = refused(page).get(reason, 0)
    yield
    limit = time.monotonic() + 60.0
    while refused(page).get(reason, 0) < before + least:
        assert time.monotonic() < limit, f"{refused(page)}"
        time.sleep(0.05)


def dial(page: Shown, stack: ExitStack, said: bytes = b"") -> socket.socket:
    host, _, port = page.host.rpartition(":")
    end = stack.enter_context(socket.create_connection((host, int(port)), timeout=60))
    end.sendall(said)
    return end


def frame(opcode: int, payload: bytes, *, final: bool = True) -> bytes:
    """A frame as a browser sends it."""
    masked = bytes(byte ^ MASK[place % 4] for place, byte in enumerate(payload))
    size = (
        struct.pack("!BH", 0x80 | 126, len(payload)) if len(payload) > 125 else bytes([0x80 | len(payload)])
    )
    return bytes([(0x80 if final else 0) | opcode]) + size + MASK + masked


def looking(page: Shown, stack: ExitStack) -> socket.socket:
    """A WebSocket, by hand."""
    end = dial(page, stack, UPGRADE.format(host=page.host).replace("\n", "\r\n").encode())
    assert b"101 Switching" in end.recv(1000)
    return end


def alive(page: Shown) -> None:
    """An operator gets the page, and sees the run."""
    assert page.get("")[0] == 200
    with page.look(f"http://{page.host}") as browser:
        assert next(things(browser, "scene"))["graph"] == "glowballs"


THOROUGH = pytest.mark.thorough
SAID = [
    b"GET / HTTP/1.1\r\nHost: ",
    pytest.param(b"", marks=THOROUGH),
    pytest.param(b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 9999\r\n\r\n", marks=THOROUGH),
]


@pytest.mark.parametrize("said", SAID)
def test_three_hundred_connections_without_a_request_keep_no_browser_out(page: Shown, said: bytes) -> None:
    moved_on = CROWD - MAX_WAITING - 2
    with ExitStack() as crowd:
        with refusing(page, "crowded", moved_on):
            for _ in range(CROWD):
                dial(page, crowd, said)
            alive(page)
        with page.look() as browser:  # who looks on waits no more, and is not moved on
            next(things(browser, "scene"))
            with refusing(page, "crowded", moved_on):
                for _ in range(CROWD):
                    dial(page, crowd, said)
            browser.ping().wait(60)
            browser.send('{"stage": "nobody", "key": "a", "value": "b"}')
            assert not next(things(browser, "answer"))["ok"]


def test_who_asks_for_nothing_is_shown_out_after_a_while(page: Shown) -> None:
    with ExitStack() as stack, refusing(page, "silent", 2):
        silent = [dial(page, stack, said) for said in (b"", b"GET / HT")]
        for end in silent:
            with suppress(ConnectionResetError):
                assert end.recv(1) == b""
    alive(page)


@pytest.mark.parametrize("payload", [b"\xff\xfe", b'{"stage": "\xc3\x28"}', b"\xed\xa0\x80"])
def test_text_that_is_no_utf8_closes_with_1007_and_is_counted(page: Shown, payload: bytes) -> None:
    with ExitStack() as stack, refusing(page, "not UTF-8"):
        browser = stack.enter_context(page.look())
        next(things(browser, "scene"))
        browser.socket.sendall(frame(TEXT, payload))
        with pytest.raises(ConnectionClosedError) as closed:
            list(things(browser, "nothing"))
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1007
    alive(page)


@pytest.mark.parametrize(
    "said",
    [
        frame(TEXT, b"a" * (MAX_HEARD + 1)),
        frame(TEXT, b"a" * 3000, final=False) + frame(CONTINUED, b"a" * 3000),
        b"\x81\xff" + b"\xff" * 8 + MASK,  # 2^64 - 1 bytes to come
        b"\x81\xfe\xff\xff" + MASK,
        frame(CONTINUED, b"a"),
        frame(3, b"a"),
        frame(CLOSE, b"\0"),
        frame(CLOSE, struct.pack("!H", 999) + b"\xff"),
        frame(PING, b"a" * 200),
        b"\x81\x05hello",  # not masked
        b"\xf1\x80" + MASK,  # reserved bits
    ],
)
def test_frames_that_are_none_close_the_connection_alone(page: Shown, said: bytes) -> None:
    with ExitStack() as stack:
        end = looking(page, stack)
        end.sendall(said)
        while end.recv(1 << 16):
            continue
        alive(page)


@pytest.mark.parametrize(
    ("piece", "enough"),
    [(frame(CONTINUED, b"", final=False), MAX_FRAGMENTS), (frame(PING, b"a" * 125), 100_000)],
)
def test_floods_of_small_frames_are_cut_off_and_counted(page: Shown, piece: bytes, enough: int) -> None:
    """Pieces of a message that never ends; pings whose echoes nobody reads."""
    with ExitStack() as stack, refusing(page, "flood"):
        end = looking(page, stack)
        end.sendall(frame(TEXT, b"", final=False) if piece[0] == CONTINUED else b"")
        with suppress(ConnectionError):
            for _ in range(100_000):
                end.sendall(piece * (enough // 100 + 1))
            while end.recv(1 << 16):  # small pieces may all lie in the socket before the page reads them
                continue
    alive(page)


@pytest.mark.parametrize(
    "value", ["9" * 500, "1e999", "-1e999", ".nan", ".inf", "[" * 400, "\0", "&a [*a]", "!!python/name:os"]
)
def test_values_without_measure_are_answered(page: Shown, value: str) -> None:
    with page.look(f"http://{page.host}") as browser:
        next(scene for scene in things(browser, "scene") if scene["forms"])
        for key in ("maximum_iterations", "", "\0", "a" * 300):
            browser.send(json.dumps({"stage": "fuse", "key": key, "value": value}))
            assert isinstance(next(things(browser, "answer"))["ok"], bool)


@pytest.mark.parametrize(
    "said",
    [
        b"\x16\x03\x01\x02\0",  # TLS
        b"GET / HTTP/9.9\r\n\r\n",
        b"GET \xff\xfe HTTP/1.1\r\nHost: a\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n" + b"a: b\r\n" * 20_000,
        b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n",
        b"GET /look HTTP/1.1\r\nHost: %s\r\nUpgrade: h2c\r\nConnection: Upgrade\r\n\r\n",
        b"GET /look HTTP/1.1\r\nHost: %s\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
        b"GET /%00%ff HTTP/1.1\r\nHost: %s\r\n\r\n",
        b"GET /static/%00 HTTP/1.1\r\nHost: %s\r\n\r\n",
    ],
)
def test_requests_that_are_none_are_refused_without_a_word(page: Shown, said: bytes) -> None:
    with ExitStack() as stack:
        end = dial(page, stack, said.replace(b"%s", page.host.encode()))
        with suppress(ConnectionResetError):
            assert not end.recv(1 << 16).startswith(b"HTTP/1.1 200")
        alive(page)
