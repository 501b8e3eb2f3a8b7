"""The camera of Aravis or of viva-genicam in a process of its own: fake_camera.py KIND ADDRESS JSON.

JSON: {"fps": ..., "drop": [[number, packet], ...]}, of which Aravis' camera knows neither. Prints a line when
it runs; when its input ends, it prints JSON: how many triggers and action commands the camera has heard.
"""

from __future__ import annotations

import json
import socket
import sys
import threading
from collections.abc import Callable
from typing import Any

from tests.plugins.cameras.gvcp_camera import PORT

SIZE = (64, 48)
PERIOD = 0x138
"""Register of Aravis' camera: from one picture to the next, us."""
Heard = Callable[[], dict[str, int]]


def aravis(address: str, options: dict[str, Any]) -> Heard:
    import gi

    gi.require_version("Aravis", "0.8")
    from gi.repository import Aravis

    fake = Aravis.GvFakeCamera.new(address, f"GV{address.rpartition('.')[2]}")
    assert fake.is_running()
    fake.get_fake_camera().write_register(PERIOD, round(1e6 / options["fps"]))
    return lambda: {"running": int(fake.is_running())}


def viva_genicam(address: str, options: dict[str, Any]) -> Heard:
    from viva_genicam.testing import FakeGigeCamera

    drop = [(number, packet) for number, packet in options["drop"]]
    fake = FakeGigeCamera(*SIZE, options["fps"], address, packet_resend=False, drop_packets=drop)
    fake.start()
    for everybody in ("255.255.255.255", f"{address.rpartition('.')[0]}.255"):
        threading.Thread(target=relay, args=(address, everybody), daemon=True).start()
    return lambda: {"software": fake.software_triggers(), "action": fake.actions()}


def relay(address: str, everybody: str) -> None:
    """Ask the camera on behalf of those who ask everybody: it hears only what is sent to its own address."""
    here, there = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    here.bind((everybody, PORT))
    there.bind((address, 0))
    there.settimeout(60)
    while True:
        packet, sender = here.recvfrom(2048)
        there.sendto(packet, (address, PORT))
        if packet[1] & 1:  # an answer is wanted
            there.sendto(there.recv(2048), sender)


def main(kind: str, address: str, options: dict[str, Any]) -> None:
    heard = {"aravis": aravis, "viva-genicam": viva_genicam}[kind](address, options)
    print("running", flush=True)
    sys.stdin.read()
    print(json.dumps(heard()))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], json.loads(sys.argv[3]))
