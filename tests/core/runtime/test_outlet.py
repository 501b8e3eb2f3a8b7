"""The sending end: what cannot be sent is counted, and goes nowhere."""

from __future__ import annotations

import socket

from followspot.messages import Header, Message
from followspot.runtime.inlet import Inlet
from followspot.runtime.ledger import Ledger
from followspot.runtime.outlet import Outlet
from followspot.transport.ring_reader import RingReader
from followspot.transport.ring_writer import RingWriter


class Note(Message):
    text: str


class Memo(Message):
    text: str


def outlet_with_ring(ledger: Ledger) -> tuple[Outlet, Inlet, Inlet, list[str]]:
    """An outlet with a reader in the same worker (edge 0) and one across a ring (edge 1)."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    outlet = Outlet(Note, ledger.words, slack=0)
    near = Inlet("near", ledger.words, ledger.row(0), depth=8, slack=0)
    far = Inlet("far", ledger.words, ledger.row(1), depth=8, slack=0)
    far.reader = RingReader(theirs, Note)
    outlet.inlets.append(near)
    outlet.attach(RingWriter([ours], 8), ["a.out -> b.in"], [ledger.row(1)])
    complaints: list[str] = []
    outlet.refused = complaints.append
    return outlet, near, far, complaints


def test_a_message_too_large_to_travel_is_invalid_on_the_ring_and_delivered_nearby() -> None:
    ledger = Ledger(2)
    outlet, near, far, complaints = outlet_with_ring(ledger)
    outlet.send(Note("x" * 100_000), Header("a", 0, 0))
    outlet.send(Note("short"), Header("a", 1, 10))
    far.poll()
    assert [m.text for m in far.queue] == ["short"]  # type: ignore[attr-defined]
    assert len(near.queue) == 2
    assert (ledger.count(1).sent, ledger.count(1).invalid, ledger.count(0).invalid) == (2, 1, 0)
    assert len(complaints) == 1


def test_another_type_than_declared_is_invalid_everywhere_and_settles_its_time() -> None:
    ledger = Ledger(2)
    outlet, near, far, complaints = outlet_with_ring(ledger)
    outlet.send(Memo("hello"), Header("a", 0, 5))
    far.poll()
    assert (ledger.count(0).invalid, ledger.count(1).invalid) == (1, 1)
    assert (near.bound, far.bound) == (6, 6)
    assert complaints == ["is a Memo, declared Note"]
