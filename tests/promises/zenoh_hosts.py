"""Hosts for the ends of Zenoh edges, and the cables between them."""

from __future__ import annotations

import zenoh
from tests.integration.hosts import free_port
from tests.promises.cable import Cable, session

from followspot.transport.zenoh.session import close_session

READERS = 2
"""Readers of a port, each on a host of its own."""


class Hosts:
    """The hosts of all examples: two that a writer may be on, and one for each reader."""

    def __init__(self) -> None:
        self._ports = [free_port(), free_port()]
        self.of_writer = [session(listen=port) for port in self._ports]
        self._of_reader: list[zenoh.Session | None] = [None] * READERS
        self._cables = [[Cable(port) for _ in range(READERS)] for port in self._ports]
        """From each host of a writer to each reader."""
        self.cable = self._cables[0][0]
        """The cable from the first host of a writer to the first reader: the one that examples cut."""

    def of_reader(self, index: int) -> zenoh.Session:
        """The session on a reader's host, which is started if need be."""
        found = self._of_reader[index]
        if found is None:
            endpoints = [cables[index].endpoint for cables in self._cables]
            found = self._of_reader[index] = session(connect=endpoints)
        return found

    def reader_host_dies(self, index: int) -> None:
        """Its system closes its connections."""
        if index == 0:
            self.cable.release()
        close_session(self.of_reader(index))
        self._of_reader[index] = None

    def writer_host_dies(self, number: int) -> None:
        """Its system closes its connections, and it starts again.

        Its cables are cut first: a session that is reached while it closes would live on in this process.
        """
        for cable in self._cables[number]:
            cable.cut()
        close_session(self.of_writer[number])
        self.of_writer[number] = session(listen=self._ports[number])
        for cable in self._cables[number]:
            cable.mend()

    def close(self) -> None:
        for cables in self._cables:
            for cable in cables:
                cable.close()
        for one in (*self._of_reader, *self.of_writer):
            if one is not None:
                close_session(one)
