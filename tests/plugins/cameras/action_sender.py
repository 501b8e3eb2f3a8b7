"""Sends action commands with the keys of viva-genicam's camera: action_sender.py INTERFACE COUNT."""

from __future__ import annotations

import sys

from viva_genicam.testing import FakeGigeCamera

from followspot.room import Sync
from followspot_cameras.genicam.triggers import ActionCommands


def main(interface: str, count: int) -> None:
    keys = FakeGigeCamera.DEVICE_KEY, FakeGigeCamera.GROUP_KEY, FakeGigeCamera.GROUP_MASK
    send = ActionCommands(Sync("action", "left", 20.0, *keys), interface, print)
    for _ in range(count):
        send()
    print("sent", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
