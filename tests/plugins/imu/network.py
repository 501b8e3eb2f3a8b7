"""A network sensor at work: datagrams from a sender of the test, messages and warnings of the stage."""

from __future__ import annotations

import socket
import struct
import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from pythonosc.osc_message_builder import OscMessageBuilder

from followspot import Context, Member
from followspot.inertial import Inertial
from followspot.message_checks.sealing import seal
from followspot.testing import tiny_room
from followspot_imu.network.sensor import NetworkSensor

PATIENCE = 60.0
"""Longest wait for what must come, s."""


class AtWork:
    """The stage listens while the block runs; then `sent` and `told` are complete."""

    def __init__(self, kind: type[NetworkSensor], **params: Any) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = int(probe.getsockname()[1])
        self.told: list[str] = []
        self.sent: list[Inertial] = []
        context = Context("imu", tiny_room(), Member("sensors", "imu0"), warn=self.told.append)
        self.stage = kind(context, port=self.port, **params)
        self._thread = threading.Thread(target=self._listen)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def _listen(self) -> None:
        self.sent.extend(seal(message) for message in self.stage.process())

    def __enter__(self) -> Self:
        self._thread.start()
        self._wait(lambda: f":{self.port:04X} " in Path("/proc/net/udp").read_text())
        return self

    def send(self, *datagrams: bytes) -> None:
        for datagram in datagrams:
            self._socket.sendto(datagram, ("127.0.0.1", self.port))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait until every datagram was read, and end."""
        self._wait(lambda: self._unread() == 0)
        self.stage.close()
        self._thread.join(PATIENCE)
        self._socket.close()
        assert not self._thread.is_alive()

    def _unread(self) -> int:
        """Bytes that wait at the port."""
        lines = Path("/proc/net/udp").read_text().splitlines()
        (own,) = (line.split() for line in lines if f":{self.port:04X} 00000000:0000" in line)
        return int(own[4].partition(":")[2], 16)

    def _wait(self, done: Any) -> None:
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end
            time.sleep(0.005)

    def column(self, name: str) -> np.ndarray:
        """A column of all messages."""
        return np.concatenate([getattr(message, name) for message in self.sent])


def osc(address: str, *values: object, kind: str | None = None) -> bytes:
    build = OscMessageBuilder(address)
    for value in values:
        build.add_arg(value, kind)
    return build.build().dgram


def bundle(*messages: bytes) -> bytes:
    parts = b"".join(struct.pack(">I", len(message)) + message for message in messages)
    return b"#bundle\0" + bytes(7) + b"\1" + parts
