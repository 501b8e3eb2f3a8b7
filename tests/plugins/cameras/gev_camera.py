"""A GigE Vision camera in a process of its own, whose clock is off and drifts, and which tells what it took.

python gev_camera.py ADDRESS '{"fps": 60, "shift": 1e12, "drift": 5e-5, "drop": [[7, 1]]}' prints a line when
it runs; when its input ends, it prints JSON: captured, [[number, ns since 1970], ...], and the counts of
triggers. Control by GVCP, pictures by GVSP of GigE Vision 1; triggers by software and by action commands.
"""

from __future__ import annotations

import json
import socket
import struct
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from tests.plugins.cameras.gvcp_camera import PORT, Camera

WIDTH, HEIGHT, MONO8 = 64, 48, 0x0108_0001
PACKET = 1400
"""Bytes of a picture in a packet."""
ACTION = 0x0100
STREAM_PORT, STREAM_ADDRESS = 0x0D00, 0x0D18
TICKS = 0x0940
LATCH, CLOCK, START, STOP, MODE, SOURCE, SOFTWARE = 0x2000, 0x2008, 0x2100, 0x2104, 0x2108, 0x210C, 0x2110
DEVICE_KEY, GROUP_KEY, GROUP_MASK = 0x2120, 0x2124, 0x2128
BY_SOFTWARE, BY_ACTION = 0, 1
PTP = 0x2140
"""Whether it takes part, and its state, which stays as it is written."""
INTEGERS = {"Width": 0x2010, "Height": 0x2014, "PayloadSize": 0x2018, "ActionSelector": 0x212C}
INTEGERS |= {"ActionDeviceKey": DEVICE_KEY, "ActionGroupKey": GROUP_KEY, "ActionGroupMask": GROUP_MASK}
INTEGERS |= {"OffsetX": 0x2130, "OffsetY": 0x2134}
REGION = (("Width", "OffsetX", WIDTH), ("OffsetX", "Width", WIDTH))
REGION += (("Height", "OffsetY", HEIGHT), ("OffsetY", "Height", HEIGHT))
"""Features that leave each other as much as the sensor has, px."""
LIMITS = {name: f"<Min>{0 if 'Offset' in name else 8}</Min><pMax>{name}Most</pMax>" for name, *_ in REGION}
ENUMERATIONS = {
    "PixelFormat": (0x201C, {"Mono8": MONO8}),
    "PtpEnable": (PTP, {"Off": 0, "On": 1}),
    "PtpStatus": (PTP + 4, {"Disabled": 3, "Listening": 4, "Slave": 9}),
    "TriggerSelector": (0x2114, {"FrameStart": 0}),
    "TriggerMode": (MODE, {"Off": 0, "On": 1}),
    "TriggerSource": (SOURCE, {"Software": BY_SOFTWARE, "Action1": BY_ACTION}),
}
COMMANDS = {"TimestampLatch": LATCH, "AcquisitionStart": START, "AcquisitionStop": STOP}
COMMANDS |= {"TriggerSoftware": SOFTWARE}


def node_map() -> bytes:
    """The features above, by the names of the Standard Features Naming Convention."""
    names = [*INTEGERS, *ENUMERATIONS, *COMMANDS, "TimestampLatchValue", "DeviceSerialNumber"]
    features = "".join(f"<pFeature>{name}</pFeature>" for name in names)
    parts = [
        f'<Category Name="Root"><pFeature>All</pFeature></Category><Category Name="All">{features}</Category>'
    ]
    parts.append(
        '<StringReg Name="DeviceSerialNumber"><Address>0xD8</Address><Length>16</Length>'
        "<AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>"
    )
    parts += [_register(f"{name}Reg", at) for name, at in [*INTEGERS.items(), *COMMANDS.items()]]
    parts += [
        f'<Integer Name="{name}"><pValue>{name}Reg</pValue>{LIMITS.get(name, "")}</Integer>'
        for name in INTEGERS
    ]
    parts += [
        f'<IntSwissKnife Name="{name}Most"><pVariable Name="OTHER">{other}</pVariable>'
        f"<Formula>{sensor} - OTHER</Formula></IntSwissKnife>"
        for name, other, sensor in REGION
    ]
    for name in COMMANDS:
        parts.append(
            f'<Command Name="{name}"><pValue>{name}Reg</pValue><CommandValue>1</CommandValue></Command>'
        )
    for name, (at, entries) in ENUMERATIONS.items():
        written = "".join(f'<EnumEntry Name="{n}"><Value>{v}</Value></EnumEntry>' for n, v in entries.items())
        parts.append(f'<Enumeration Name="{name}">{written}<pValue>{name}Reg</pValue></Enumeration>')
        parts.append(_register(f"{name}Reg", at))
    parts.append('<Integer Name="TimestampLatchValue"><pValue>ClockReg</pValue></Integer>')
    parts.append(_register("ClockReg", CLOCK, 8))
    parts.append('<Port Name="Device"/>')
    version = "http://www.genicam.org/GenApi/Version_1_1"
    head = (
        '<RegisterDescription ModelName="Model" VendorName="Maker" ToolTip="" StandardNameSpace="GEV" '
        'SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0" MajorVersion="1" '
        'MinorVersion="0" SubMinorVersion="0" ProductGuid="1c0bd0a4-7f2b-4f7e-9d42-2f3f3a0d9f11" '
        f'VersionGuid="5e2f7b86-0f7a-4d27-8d8c-4b1c7b1b7a22" xmlns="{version}">'
    )
    return (f'<?xml version="1.0" encoding="utf-8"?>{head}{"".join(parts)}</RegisterDescription>').encode()


def _register(name: str, at: int, length: int = 4) -> str:
    return (
        f'<IntReg Name="{name}"><Address>{at:#x}</Address><Length>{length}</Length>'
        "<AccessMode>RW</AccessMode><pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>"
    )


class GevCamera(Camera):
    """fps: in free run; shift: of its clock, ns; drift: its rate less 1; drop: [number, packet], the lost."""

    def __init__(
        self, fps: float = 60, shift: float = 0, drift: float = 0, drop: Sequence[Sequence[int]] = ()
    ) -> None:
        own = [0x2010, 0x2014, 0x2018, 0x201C, CLOCK, CLOCK + 4, TICKS, 0x0D04, STREAM_PORT, STREAM_ADDRESS]
        own += [*COMMANDS.values(), *(at for at, _ in ENUMERATIONS.values()), *INTEGERS.values()]
        super().__init__(node_map(), dict.fromkeys(own, 0))
        self.registers |= {0x2010: WIDTH, 0x2014: HEIGHT, 0x2018: WIDTH * HEIGHT, 0x201C: MONO8}
        self.registers |= {TICKS: 10**9, 0x0D04: PACKET + 36}
        self._word(0x0904, 1)  # stream channels
        self._period, self._shift, self._drift = 1 / fps, round(shift), drift
        self._drop = {(number, packet) for number, packet in drop}
        self._began = time.time_ns()
        self._running, self._ended, self._triggers = (
            threading.Event(),
            threading.Event(),
            threading.Semaphore(0),
        )
        self._stream = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.captured: list[tuple[int, int]] = []
        self.heard: Counter[str] = Counter()
        self.claimed: tuple[int, int] | None = None
        """Size that pictures claim, whatever they have, px."""
        self.spoil: Callable[[int, int, bytes], bytes] = lambda number, place, packet: packet
        """What becomes of a packet: its picture, its place, itself."""

    def clock(self, now: int) -> int:
        """Its time at a time since 1970, ns."""
        passed = now - self._began
        return self._shift + passed + round(passed * self._drift)

    def write(self, at: int, data: bytes) -> None:
        if at == LATCH:
            time_now = self.clock(time.time_ns())
            self.registers[CLOCK], self.registers[CLOCK + 4] = divmod(time_now, 1 << 32)
        super().write(at, data)
        if at == START:
            self._running.set()
        elif at == STOP:
            self._running.clear()
        elif at == SOFTWARE and self.registers[MODE]:
            self._trigger("software", BY_SOFTWARE)

    def answer(self, command: int, body: bytes) -> bytes:
        if command != ACTION:
            return super().answer(command, body)
        device, group, mask = struct.unpack_from(">III", body)
        keys = self.registers[DEVICE_KEY], self.registers[GROUP_KEY]
        if (device, group) == keys and mask & self.registers[GROUP_MASK]:
            self._trigger("action", BY_ACTION)
        return b""

    def _trigger(self, kind: str, source: int) -> None:
        self.heard[kind] += 1
        if self.registers[SOURCE] == source:
            self._triggers.release()

    def work(self) -> None:
        """Take pictures until the camera is ended."""
        number, due = 0, time.monotonic()
        while not self._ended.is_set():
            if not self._running.wait(0.05):
                number, due = 0, time.monotonic()
                continue
            if self.registers[MODE]:
                if not self._triggers.acquire(timeout=0.05):
                    continue
            else:
                due = max(due + self._period, time.monotonic())  # a busy host makes no bursts
                self._ended.wait(max(0.0, due - time.monotonic()))
            number = number % 65_535 + 1
            now = time.time_ns()
            self.captured.append((number, now))
            self._send(number, self.clock(now))

    def _send(self, number: int, stamp: int) -> None:
        to = socket.inet_ntoa(struct.pack(">I", self.registers[STREAM_ADDRESS])), self.registers[STREAM_PORT]
        leader = struct.pack(">HHII", 0, 1, *divmod(stamp, 1 << 32))
        width, height = (self.registers[INTEGERS[name]] for name in ("Width", "Height"))
        leader += struct.pack(">IIIIIHH", MONO8, *(self.claimed or (width, height)), 0, 0, 0, 0)
        picture = bytes([number % 200]) * (width * height)
        parts = [picture[at : at + PACKET] for at in range(0, len(picture), PACKET)]
        packets = [(1, leader), *((3, part) for part in parts), (2, struct.pack(">HHI", 0, 1, height))]
        for place, (kind, data) in enumerate(packets):
            if (number, place) not in self._drop:
                head = struct.pack(">HHI", 0, number, kind << 24 | place)
                self._stream.sendto(self.spoil(number, place, head + data), to)

    def end(self) -> None:
        self._ended.set()


def serve(camera: GevCamera, address: str) -> None:
    """Answer for ever, at an address and to broadcasts."""
    camera._boot[0x24:0x28] = socket.inet_aton(address)
    camera._boot[0x08:0x10] = b"\0\0\xac\xde" + socket.inet_aton(address)
    port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    port.bind(("", PORT))
    while True:
        packet, sender = port.recvfrom(2048)
        _, flags, command, length, number = struct.unpack_from(">BBHHH", packet)
        answer = camera.answer(command, packet[8 : 8 + length])
        if flags & 1:
            port.sendto(struct.pack(">HHHH", 0, command + 1, len(answer), number) + answer, sender)


def main(address: str, options: dict[str, Any]) -> None:
    camera = GevCamera(**options)
    threading.Thread(target=serve, args=(camera, address), daemon=True).start()
    taking = threading.Thread(target=camera.work)
    taking.start()
    print("running", flush=True)
    sys.stdin.read()
    camera.end()
    taking.join()
    print(json.dumps({"captured": camera.captured, "heard": camera.heard}))


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]))
