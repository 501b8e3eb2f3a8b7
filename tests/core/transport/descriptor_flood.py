"""A ring and a control channel while too many descriptors of the user are on their way.

usage: python descriptor_flood.py

Prints what has arrived once there is room again, and what was logged. It gives up the rights of root, for
whom there is no limit.
"""

from __future__ import annotations

import io
import json
import logging
import os
import resource
import socket
import sys
from threading import Timer

from tests.core.transport.rings import Ring, frame, messages

from followspot.control.dispatch import by_verb
from followspot.control.lifecycle import StopRun
from followspot.control.pipe import Channel

LIMIT = 64
"""Descriptors that the process may have open, and more than which its user may not have on their way."""


class Flood:
    """More descriptors on their way than are allowed."""

    def __init__(self) -> None:
        self.ours, self.theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.count = 0
        try:
            while True:
                socket.send_fds(self.ours, [b"x"], [self.ours.fileno()])
                self.count += 1
        except OSError:
            pass

    def drain(self) -> None:
        for _ in range(self.count):
            for descriptor in socket.recv_fds(self.theirs, 1, 1)[1]:
                os.close(descriptor)


def through_ring() -> list[int]:
    """Frames sent while there was no room for the memory of the ring, as they arrive."""
    flood = Flood()
    with Ring() as ring:
        ring.writer.send(frame(0))
        ring.writer.send(frame(1))
        early = ring.readers[0].poll()
        flood.drain()
        assert ring.writer.flush()
        assert not ring.writer.lost
        return [m.header.seq for m in messages([*early, *ring.readers[0].poll()])]


def through_channel() -> list[int]:
    """How many descriptors come with a request that was sent while there was no room for any."""
    ours, theirs = socket.socketpair()
    sending = Channel(ours, {})
    receiving = Channel(theirs, by_verb([StopRun]))
    flood = Flood()
    Timer(0.2, flood.drain).start()
    sending.send_if_open(StopRun(), (sys.stderr.fileno(),))
    sending.close()
    return [len(receiving.receive().descriptors)]


def main() -> None:
    resource.setrlimit(resource.RLIMIT_NOFILE, (LIMIT, LIMIT))
    if os.getuid() == 0:
        os.setuid(65534)
    logged = io.StringIO()
    logging.basicConfig(stream=logged, format="%(message)s")
    arrived = {"ring": through_ring(), "channel": through_channel()}
    print(json.dumps({**arrived, "logged": logged.getvalue().splitlines()}))


if __name__ == "__main__":
    main()
