"""A cable between two sessions that a test can hold and cut; bytes in a cable that is cut are lost."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Sequence

import zenoh

from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import config_of


class Cable:
    """Leads from `endpoint` to a port of loopback, as long as it is whole."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._open = True
        self._moves = threading.Event()
        self._moves.set()
        self._ends: list[socket.socket] = []
        self._lock = threading.Lock()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.endpoint = f"tcp/127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def hold(self) -> None:
        """Let no byte arrive, in either direction."""
        self._moves.clear()

    def release(self) -> None:
        """Let the bytes arrive that were held."""
        self._moves.set()

    def cut(self) -> None:
        """Lose the bytes that are on their way, and refuse connections."""
        with self._lock:
            self._open = False
            for end in self._ends:
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)
            self._ends.clear()
        self._moves.set()

    def mend(self) -> None:
        """Accept connections again."""
        self._open = True

    def close(self) -> None:
        """For ever."""
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self.cut()

    def _accept(self) -> None:
        while True:
            try:
                near, _ = self._listener.accept()
            except OSError:
                return
            with self._lock:
                if not self._open:
                    near.close()
                    continue
                try:
                    far = socket.create_connection(("127.0.0.1", self._port))
                except OSError:
                    near.close()
                    continue
                self._ends += near, far
            for one, other in ((near, far), (far, near)):
                threading.Thread(target=self._pump, args=(one, other), daemon=True).start()

    def _pump(self, one: socket.socket, other: socket.socket) -> None:
        """Carry bytes one way; those that came while the cable was held and then cut are lost."""
        with contextlib.suppress(OSError):
            while data := one.recv(1 << 16):
                self._moves.wait()
                other.sendall(data)
        for end in (one, other):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
        one.close()


def session(*, listen: int = 0, connect: Sequence[str] = ()) -> zenoh.Session:
    """A peer that connects only to the ports that it is given: gossip would lead around the cable."""
    here = (f"tcp/127.0.0.1:{listen}",) if listen else ()
    config = config_of(Network(listen=here, connect=tuple(connect)))
    config.insert_json5("scouting/gossip/enabled", "false")
    return zenoh.open(config)
