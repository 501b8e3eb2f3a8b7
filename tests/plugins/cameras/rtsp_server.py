"""A network camera: RTSP on loopback, H.264 by TCP or UDP, a clock of its own that may be off.

By UDP, `fate` tells what happens to the packets of its pictures.
"""

from __future__ import annotations

import re
import socket
import struct
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction

import av
import numpy as np

from followspot_cameras.rtsp.rtp import EPOCH

SIZE = (64, 48)
RATE = 90_000
PACKET = 300
"""Bytes of a packet: pictures need several."""


def encoded(count: int = 10) -> list[list[bytes]]:
    """NAL units of one group of pictures, whose brightness rises from picture to picture."""
    context = av.VideoCodecContext.create("libx264", "w")
    context.width, context.height = SIZE
    context.pix_fmt = "yuv420p"
    context.time_base = Fraction(1, 20)
    context.options = {"preset": "ultrafast", "tune": "zerolatency", "g": str(count), "threads": "1"}
    noise = np.random.default_rng(0).integers(0, 40, (SIZE[1], SIZE[0], 3))
    pictures = []
    for number in range(count):
        picture = (30 + 20 * number + noise).clip(0, 255).astype("u1")
        frame = av.VideoFrame.from_ndarray(picture, format="bgr24").reformat(format="yuv420p")
        frame.pts = number
        for packet in context.encode(frame):
            units = re.split(b"\x00\x00\x00?\x01", bytes(packet))
            pictures.append([unit for unit in units if unit])
    return pictures


Fate = Callable[[int, bytes], Sequence[bytes]]
"""Packets that a network delivers when the n-th one is sent."""


def delivered(number: int, packet: bytes) -> Sequence[bytes]:
    return [packet]


@dataclass
class RtspCamera:
    """shift: of its clock, s; drift: its rate less 1; latency: of its encoder, s; reports: s between them;
    fate: of the packets of pictures by UDP; takes_udp: whether it sends by UDP at all.
    """

    shift: float = 0.0
    drift: float = 0.0
    latency: float = 0.0
    reports: float | None = 0.2
    fps: float = 20.0
    port: int = 0
    password: str = ""
    fate: Fate = delivered
    takes_udp: bool = True
    pictures: list[list[bytes]] = field(default_factory=encoded)
    captured: list[int] = field(default_factory=list)
    """True capture times of what was sent, ns."""
    requests: list[str] = field(default_factory=list)

    def __enter__(self) -> RtspCamera:
        self._ended = threading.Event()
        self._there: int | None = None
        self._sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._sender.bind(("127.0.0.1", 0))
        self.sent = 0
        self._listening = socket.create_server(("127.0.0.1", self.port))
        self.port = self._listening.getsockname()[1]
        self._began = time.time()
        self._threads = [threading.Thread(target=self._serve, daemon=True)]
        self._threads[0].start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()
        for thread in self._threads:
            thread.join(5)
        self._sender.close()

    @property
    def url(self) -> str:
        user = f"viewer:{self.password}@" if self.password else ""
        return f"rtsp://{user}127.0.0.1:{self.port}/cam"

    def clock(self, now: float) -> float:
        return now + self.shift + self.drift * (now - self._began)

    def _serve(self) -> None:
        while not self._ended.is_set():
            try:
                client, _ = self._listening.accept()
            except OSError:
                return
            with suppress(ConnectionError):  # the client has left
                self._talk(client)

    def _talk(self, client: socket.socket) -> None:
        client.settimeout(0.1)
        text, sender = b"", None
        with client:
            while not self._ended.is_set():
                try:
                    more = client.recv(4096)
                except TimeoutError:
                    continue
                except OSError:
                    break
                if not more:
                    break
                text += more
                while b"\r\n\r\n" in text:
                    head, _, text = text.partition(b"\r\n\r\n")
                    method = head.split(b" ")[0].decode()
                    self.requests.append(head.decode())
                    client.sendall(self._answer(method, head.decode()))
                    if method == "PLAY":
                        sender = threading.Thread(target=self._play, args=(client,), daemon=True)
                        sender.start()
            client.close()
            if sender is not None:
                sender.join(5)

    def _answer(self, method: str, head: str) -> bytes:
        number = re.search(r"CSeq: (\d+)", head)
        assert number is not None
        start = f"\r\nCSeq: {number[1]}\r\n"
        if self.password and "Authorization" not in head:
            asked = 'WWW-Authenticate: Digest realm="camera", nonce="5ca1ab1e"\r\n\r\n'
            return f"RTSP/1.0 401 Unauthorized{start}{asked}".encode()
        more = ""
        ports = re.search(r"client_port=(\d+)-(\d+)", head)
        if method == "SETUP" and ports is not None:
            if not self.takes_udp:
                return f"RTSP/1.0 461 Unsupported Transport{start}\r\n".encode()
            self._there = int(ports[1])
            own = self._sender.getsockname()[1]
            more = f"Transport: RTP/AVP;unicast;client_port={ports[1]}-{ports[2]};server_port={own}-{own}\r\n"
        body = ""
        if method == "DESCRIBE":
            body = "v=0\r\nm=audio 0 RTP/AVP 0\r\na=rtpmap:0 PCMU/8000\r\nm=video 0 RTP/AVP 96\r\n"
            body += f"a=rtpmap:96 H264/{RATE}\r\na=control:track1\r\n"
        head = f"RTSP/1.0 200 OK{start}Session: 7;timeout=60\r\n{more}Content-Length: {len(body)}\r\n\r\n"
        return (head + body).encode()

    def _play(self, client: socket.socket) -> None:
        pictures, sequence, reported = self.pictures, 65_530, 0.0
        origin = time.time()
        number = 0
        while not self._ended.wait(max(0.0, origin + number / self.fps - time.time())):
            now = time.time()
            stamp = 4_294_900_000 + round((self.clock(now) - self.clock(origin)) * RATE)
            self._ended.wait(self.latency)
            try:
                sequence = self._send(client, pictures[number % len(pictures)], sequence, stamp)
                self.captured.append(round(now * 1e9))
                if self.reports is not None and now - reported >= self.reports and number:
                    reported = now
                    self._report(client, origin)
            except OSError:
                return
            number += 1

    def _send(self, client: socket.socket, units: list[bytes], sequence: int, stamp: int) -> int:
        payloads = []
        for unit in units:
            if len(unit) <= PACKET:
                payloads.append(unit)
                continue
            parts = [unit[1 + n : 1 + n + PACKET] for n in range(0, len(unit) - 1, PACKET)]
            for n, part in enumerate(parts):
                marks = (0x80 if n == 0 else 0) | (0x40 if n == len(parts) - 1 else 0) | unit[0] & 0x1F
                payloads.append(bytes([unit[0] & 0xE0 | 28, marks]) + part)
        for n, payload in enumerate(payloads):
            marker = 0x80 if n == len(payloads) - 1 else 0
            head = struct.pack(">BBHII", 0x80, marker | 96, sequence & 0xFFFF, stamp & 0xFFFFFFFF, 7)
            packet = head + payload
            self._put(client, 0, packet)
            sequence += 1
        return sequence

    def _put(self, client: socket.socket, channel: int, packet: bytes) -> None:
        if self._there is None:
            client.sendall(struct.pack(">BBH", 0x24, channel, len(packet)) + packet)
            return
        packets = [packet]
        if channel == 0:
            packets = list(self.fate(self.sent, packet))
            self.sent += 1
        for one in packets:
            self._sender.sendto(one, ("127.0.0.1", self._there + channel))

    def _report(self, client: socket.socket, origin: float) -> None:
        now = self.clock(time.time())
        stamp = 4_294_900_000 + round((now - self.clock(origin)) * RATE)
        ntp = int((now + EPOCH) * 2**32)
        report = struct.pack(">BBHIQIII", 0x80, 200, 6, 7, ntp, stamp & 0xFFFFFFFF, 0, 0)
        self._put(client, 1, report)
