"""A camera on loopback that only tells of itself: its node map and its registers, by GVCP of GigE Vision."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

PORT = 3956
HEADER = struct.Struct(">BBHHH")
DISCOVERY, READ_REGISTER, WRITE_REGISTER, READ_MEMORY, WRITE_MEMORY = 0x02, 0x80, 0x82, 0x84, 0x86
CODE_AT, URL_AT, XML_AT = 0x0000, 0x0200, 0x10000
"""Bootstrap registers of GigE Vision: what discovery tells, where the node map is; and the node map."""
CONTROL_AT = 0x0A00
"""Control channel privilege."""


class Camera:
    """memory: address -> 32-bit value; written: the registers that were written, in order."""

    def __init__(self, xml: bytes, registers: Mapping[int, int]) -> None:
        self.xml = xml
        self.registers = dict(registers)
        self.written: list[tuple[int, int]] = []
        self._boot = bytearray(0x1000)
        texts = {0x48: b"Maker", 0x68: b"Model", 0x88: b"1.0", 0xD8: b"SN-PTP-1", 0xE8: b"stage left"}
        url = f"Local:ptp.xml;{XML_AT:x};{len(xml):x}".encode()
        for at, text in {**texts, URL_AT: url}.items():
            self._boot[at : at + len(text)] = text
        self._word(0x00, 0x0002_0000)  # GigE Vision 2.0
        self._word(0x04, 0x8000_0001)  # big endian, UTF-8
        self._word(0x0C, 0xACDE_4800_0001 & 0xFFFF_FFFF)
        self._boot[0x24:0x28] = socket.inet_aton("127.0.0.1")

    def _word(self, at: int, value: int) -> None:
        self._boot[at : at + 4] = struct.pack(">I", value)

    def read(self, at: int, count: int) -> bytes:
        if at >= XML_AT and at < XML_AT + len(self.xml) + 4:
            return self.xml[at - XML_AT :][:count].ljust(count, b"\0")
        if at in self.registers:
            words = (self.registers.get(at + n, 0) & 0xFFFF_FFFF for n in range(0, count, 4))
            return b"".join(struct.pack(">I", word) for word in words)
        return bytes(self._boot[at : at + count]).ljust(count, b"\0")

    def write(self, at: int, data: bytes) -> None:
        for n in range(0, len(data), 4):
            (value,) = struct.unpack_from(">I", data, n)
            self.written.append((at + n, value))
            if at + n in self.registers:
                self.registers[at + n] = value
            else:
                self._word(at + n, value)

    def answer(self, command: int, body: bytes) -> bytes:
        if command == DISCOVERY:
            return bytes(self._boot[:0xF8])
        if command == READ_REGISTER:
            return b"".join(self.read(at, 4) for (at,) in struct.iter_unpack(">I", body))
        if command == READ_MEMORY:
            at, count = struct.unpack(">II", body)
            return body[:4] + self.read(at, count & 0xFFFF)
        if command == WRITE_REGISTER:
            for at, value in struct.iter_unpack(">II", body):
                self.write(at, struct.pack(">I", value))
            return struct.pack(">HH", 0, len(body) // 8)
        if command == WRITE_MEMORY:
            (at,) = struct.unpack_from(">I", body)
            self.write(at, body[4:])
            return struct.pack(">HH", 0, len(body) - 4)
        raise ValueError(f"command {command:#x}")


@contextmanager
def serving(camera: Camera) -> Iterator[Camera]:
    """The camera answers on 127.0.0.1 until the context ends."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
        port.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        port.bind(("127.0.0.1", PORT))
        port.settimeout(0.1)
        over = threading.Event()

        def work() -> None:
            while not over.is_set():
                try:
                    packet, sender = port.recvfrom(2048)
                except TimeoutError:
                    continue
                _, _, command, length, number = HEADER.unpack_from(packet)
                answer = camera.answer(command, packet[8 : 8 + length])
                port.sendto(struct.pack(">HHHH", 0, command + 1, len(answer), number) + answer, sender)

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        try:
            yield camera
        finally:
            over.set()
            thread.join(10)
