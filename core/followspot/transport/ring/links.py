"""The readers of a ring that its writer has: which are alive, and which share datagrams.

Edges that lead from one port to one process share the datagrams of the first of them, its carrier: each
datagram wakes that process once. Each edge keeps its own credit, and its own socket, whose end is its death.
"""

from __future__ import annotations

import socket
from collections.abc import Sequence
from typing import NamedTuple

from followspot.transport.ring.control import CONSUMED, Control, released_word
from followspot.transport.ring.link import Link
from followspot.transport.ring.memory import Memory
from followspot.transport.ring.notification import ARENA, CARRIED, CARRIES, HELLO, NOTIFICATION
from followspot.transport.ring.slots import Slots


class ReaderLocation(NamedTuple):
    """The worker of a reader, and the number of its edge."""

    worker: str
    edge: int


class ReaderLinks:
    """The links to all readers of a port; a reader is named by its index."""

    def __init__(self, sockets: Sequence[socket.socket], depth: int, quota: int, slots: int) -> None:
        """depth: messages in flight; quota: most leases of a reader; slots: of the ring."""
        self._depth = depth
        self._quota = quota
        self._slots = slots
        self._expelled = 0
        self._newly_dead: list[tuple[int, int]] = []
        self.dismissed: list[Control] = []
        """Words of readers that left the graph: their stages may still hold messages in slots."""
        self.all = [self._linked(sock, 0, None) for sock in sockets]
        self._note_living()

    def share(self, locations: Sequence[ReaderLocation]) -> None:
        """Let readers of one worker share datagrams; call before anything is sent.

        locations: of all readers.
        """
        carriers: dict[str, tuple[Link, int]] = {}
        for location, link in zip(locations, self.all, strict=True):
            carrier, edge = carriers.setdefault(location.worker, (link, location.edge))
            if carrier is not link:
                carrier.send(NOTIFICATION.pack(CARRIES, 0, 0, 0, location.edge))
                link.send(NOTIFICATION.pack(CARRIED, 0, 0, 0, edge))
                carrier.carry(link)
        self._note_living()

    @property
    def lost(self) -> frozenset[int]:
        """Indices of the readers that are gone before the end."""
        return frozenset(i for i, link in enumerate(self.all) if not link.alive and not link.ended)

    @property
    def expelled(self) -> int:
        """How many readers were cut off."""
        return self._expelled + sum(link.expelled for link in self.all)

    def newly_dead(self) -> list[tuple[int, int]]:
        """Readers that were found dead since the last call, and the messages that they had not consumed."""
        newly_dead, self._newly_dead = self._newly_dead, []
        return newly_dead

    def replace(self, index: int, sock: socket.socket, sequence: int, pool: Slots | None) -> Link:
        """Serve a new reader on the place of a dead one, by datagrams that it shares with no other."""
        old = self.all[index]
        self._expelled += old.expelled
        self._note_death(old, sequence)
        old.socket.close()
        link = self.all[index] = self._linked(sock, sequence, pool)
        self._note_living()
        return link

    def dismiss(self, index: int, pool: Slots | None) -> None:
        """Send a reader nothing more and wait for it no longer.

        Readers that shared its datagrams get their own.
        """
        link = self.all[index]
        self.dismissed.append(link.control)
        for other in link.leave():
            if pool is not None:  # its words do not say which messages it has released: its carrier's do
                other.control.release_all(pool.arena.number, pool.stamps)
        self._note_living()

    def drain(self, sequence: int) -> None:
        """Clear wake-ups, notice deaths. sequence: messages sent so far."""
        for link in self.living:
            if link.gone():
                self._note_death(link, sequence)
        self._note_living()

    def close(self) -> None:
        """Close the sockets; readers find the end of file after the last datagram."""
        for link in self.all:
            link.alive = False
            link.part()
            link.socket.close()
        self._note_living()

    def send(self, datagram: bytes) -> None:
        """Send a message or a watermark to all readers."""
        for link in self.senders:
            link.send(datagram)

    def announce(self, pool: Slots) -> None:
        """Tell all readers of a new arena; a reader that shares datagrams now may need it later."""
        for link in self.living:
            link.send(_announced(pool), pool.arena.memory)

    def pass_over(self, arena: int, slot: int, stamp: int) -> None:
        """Note for the readers that left the graph that they do not get the message in a slot."""
        for control in self.dismissed:
            control.words[released_word(arena, self._slots) + slot] = stamp

    def expel_overclaiming(self, sequence: int) -> None:
        """Cut off readers that claim to have consumed more than was sent."""
        for link in self.living:
            if link.control.words[CONSUMED] > sequence:
                link.expel()

    def _note_death(self, link: Link, sequence: int) -> None:
        """Note the death of a reader and of those that shared its datagrams: they are in the same process."""
        for dead in (link, *link.part()):
            if dead.alive:
                dead.alive = False
                missed = max(0, sequence - dead.control.words[CONSUMED])
                self._newly_dead.append((self.all.index(dead), missed))

    def _note_living(self) -> None:
        """Take note of which readers are alive, and of their words."""
        self.living = [link for link in self.all if link.alive]
        self.senders = [link for link in self.living if link.carrier is None]
        self.controls = [link.control for link in self.living]
        self.holding = [*(link.control for link in self.senders), *self.dismissed]
        """Words that say which slots are released, also by readers that left the graph."""

    def _linked(self, sock: socket.socket, sequence: int, pool: Slots | None) -> Link:
        """The link to a new reader, for which everything so far is consumed and released."""
        control = Control(Memory.create("followspot-control", Control.size(self._slots)), self._slots)
        control.words[CONSUMED] = sequence
        link = Link(sock, control, self._depth)
        link.send(NOTIFICATION.pack(HELLO, 0, self._quota, self._slots, sequence), control.memory)
        if pool is not None:
            control.release_all(pool.arena.number, pool.stamps)
            link.send(_announced(pool), pool.arena.memory)
        return link


def _announced(pool: Slots) -> bytes:
    return NOTIFICATION.pack(ARENA, pool.arena.number, 0, 0, pool.arena.capacity)
