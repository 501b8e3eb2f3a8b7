"""A connection to an RTSP server (RFC 2326), with RTP and RTCP interleaved on it (section 10.12)."""

from __future__ import annotations

import hashlib
import re
import socket
import ssl
import time
from base64 import b64encode
from collections import deque
from typing import NamedTuple
from urllib.parse import unquote, urlsplit, urlunsplit

PORTS = {"rtsp": 554, "rtsps": 322}
MOST_HEAD = 1 << 16
MOST_BODY = 1 << 20
MOST_WAITING = 32 << 20
"""Bytes of packets that come before an answer."""


class ConnectionLost(ConnectionError):
    """The server does not answer, refuses, or has ended the connection; the text says which."""


class Packet(NamedTuple):
    """A packet of a channel. arrival: ns since 1970."""

    channel: int
    data: bytes
    arrival: int


class Response(NamedTuple):
    """Of the server. reason: why it refuses, in its words; headers: names in lower case."""

    status: int
    reason: str
    headers: dict[str, str]
    body: str


class RtspConnection:
    """Requests and packets on one connection. url: with user and password if the server wants them.

    own_address: of this host, as it faces the server; peer: the server's address.
    Every method raises ConnectionLost.
    """

    def __init__(self, url: str, open_timeout: float, read_timeout: float) -> None:
        parts = urlsplit(url)
        self._user, self._password = unquote(parts.username or ""), unquote(parts.password or "")
        self.url = urlunsplit(parts._replace(netloc=parts.netloc.rpartition("@")[2]))
        self._number, self._session, self._challenge = 0, "", ""
        self._received = b""
        self._waiting: deque[Packet] = deque()
        self._read_timeout, self._end = read_timeout, 0.0
        try:
            host, port = parts.hostname or "", parts.port or PORTS[parts.scheme]
            self._socket = socket.create_connection((host, port), timeout=open_timeout)
            self.own_address, self.peer = self._socket.getsockname()[0], self._socket.getpeername()[0]
            if parts.scheme == "rtsps":
                self._socket = ssl.create_default_context().wrap_socket(self._socket, server_hostname=host)
        except (OSError, ValueError) as error:
            raise ConnectionLost(f"cannot be reached: {error}") from None

    def fileno(self) -> int:
        """Of the socket, to wait for it together with others."""
        return self._socket.fileno()

    def request(self, method: str, url: str = "", **headers: str) -> Response:
        """The answer to a request; it is asked again with the user's name if the server wants that."""
        answer = self._asked(method, url or self.url, headers)
        if answer.status == 401 and self._user and not self._challenge:
            self._challenge = answer.headers.get("www-authenticate", "")
            answer = self._asked(method, url or self.url, headers)
        if answer.status == 401:
            raise ConnectionLost("the server wants another user or password")
        if answer.status != 200:
            raise ConnectionLost(f"the server answers {method} with {answer.status} {answer.reason}".rstrip())
        self._session = answer.headers.get("session", self._session).partition(";")[0]
        return answer

    def send(self, method: str) -> None:
        """Send a request whose answer is not waited for, to keep the session alive."""
        self._send(method, self.url, {})

    def packet(self, timeout: float) -> Packet | None:
        """The next packet; None if none comes in time, s."""
        if self._waiting:
            return self._waiting.popleft()
        self._end = time.monotonic() + timeout
        try:
            while True:
                found = self._next()
                if isinstance(found, Packet):
                    return found
        except TimeoutError:
            return None

    def close(self) -> None:
        """End the session and the connection."""
        try:
            self._send("TEARDOWN", self.url, {})
        except ConnectionLost:
            pass  # it is gone
        finally:
            self._socket.close()

    def _asked(self, method: str, url: str, headers: dict[str, str]) -> Response:
        number, waiting = self._send(method, url, headers), 0
        self._end = time.monotonic() + self._read_timeout
        try:
            while waiting < MOST_WAITING and time.monotonic() < self._end:
                found = self._next()
                if isinstance(found, Packet):
                    self._waiting.append(found)
                    waiting += len(found.data)
                elif found.headers.get("cseq", "") == str(number):
                    return found
        except TimeoutError:
            pass
        raise ConnectionLost(f"the server does not answer {method}")

    def _send(self, method: str, url: str, headers: dict[str, str]) -> int:
        self._number += 1
        lines = [f"{method} {url} RTSP/1.0", f"CSeq: {self._number}", "User-Agent: followspot"]
        lines += [f"{name}: {value}" for name, value in headers.items()]
        if self._session:
            lines.append(f"Session: {self._session}")
        if self._challenge:
            lines.append(f"Authorization: {self._credentials(method, url)}")
        try:
            self._socket.settimeout(self._read_timeout)
            self._socket.sendall("\r\n".join([*lines, "", ""]).encode())
        except OSError as error:
            raise ConnectionLost(f"the connection broke: {error}") from None
        return self._number

    def _credentials(self, method: str, url: str) -> str:
        """Basic or Digest with MD5 (RFC 2617), as the server asked."""
        if not self._challenge.lower().startswith("digest"):
            return "Basic " + b64encode(f"{self._user}:{self._password}".encode()).decode()
        asked = dict(re.findall(r'(\w+)="?([^",]*)"?', self._challenge.partition(" ")[2]))
        realm, nonce = asked.get("realm", ""), asked.get("nonce", "")
        secret = _md5(f"{self._user}:{realm}:{self._password}")
        answer = _md5(f"{secret}:{nonce}:{_md5(f'{method}:{url}')}")
        told = {"username": self._user, "realm": realm, "nonce": nonce, "uri": url, "response": answer}
        return "Digest " + ", ".join(f'{name}="{value}"' for name, value in told.items())

    def _next(self) -> Packet | Response:
        """The next packet or response. Raises TimeoutError at `_end`, and keeps what has come of it."""
        while True:
            self._need(4)
            if self._received[0] == 0x24:  # "$"
                size = int.from_bytes(self._received[2:4], "big")
                self._need(4 + size)
                return Packet(self._received[1], self._take(4 + size)[4:], time.time_ns())
            if self._received.startswith(b"RTSP"):
                return self._response()
            head = self._head()  # a request of the server: it needs no answer here
            self._take(len(head))

    def _response(self) -> Response:
        head = self._head()
        first, *lines = head.decode("utf-8", "replace").split("\r\n")
        pairs = (line.partition(":") for line in lines if ":" in line)
        headers = {name.strip().lower(): value.strip() for name, _, value in pairs}
        words = first.split()
        size = _number(headers.get("content-length", "0"))
        status = _number(words[1]) if len(words) > 1 else None
        if status is None or size is None or size > MOST_BODY:
            raise ConnectionLost("the server's answer cannot be read")
        self._need(len(head) + size)
        body = self._take(len(head) + size)[len(head) :]
        return Response(status, " ".join(words[2:]), headers, body.decode("utf-8", "replace"))

    def _head(self) -> bytes:
        while (end := self._received.find(b"\r\n\r\n")) < 0:
            if len(self._received) > MOST_HEAD:
                raise ConnectionLost("the server's answer cannot be read")
            self._need(len(self._received) + 1)
        return self._received[: end + 4]

    def _need(self, size: int) -> None:
        while len(self._received) < size:
            left = self._end - time.monotonic()
            if left <= 0:
                raise TimeoutError
            try:
                self._socket.settimeout(left)
                more = self._socket.recv(1 << 16)
            except TimeoutError:
                raise
            except OSError as error:
                raise ConnectionLost(f"the connection broke: {error}") from None
            if not more:
                raise ConnectionLost("the server ended the connection")
            self._received += more

    def _take(self, size: int) -> bytes:
        taken, self._received = self._received[:size], self._received[size:]
        return taken


def _number(text: str) -> int | None:
    """A number of at most nine digits; None if the text is none."""
    return int(text) if re.fullmatch("[0-9]{1,9}", text) else None


def _md5(text: str) -> str:
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()
