"""Slots of a ring: what is lent, sent in place, kept by readers and given back."""

from __future__ import annotations

import gc
import mmap
import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from tests.core.transport.rings import DEPTH, SHAPE, Ring, frame, messages

from followspot.errors import FollowspotError
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, Message, column, identical, stamped
from followspot.tracking import Frame
from followspot.transport.ring.slots import Slots
from followspot.transport.ring.writer import RingWriter


class Stereo(Message):
    """Two arrays, the second of which may lie in a loaned slot as well."""

    left: Array = column("H", "W", dtype="u1")
    right: Array = column("H", "W", dtype="u1")


def address(array: Array) -> int:
    return int(array.ctypes.data)


def mapped_slots() -> int:
    return Path("/proc/self/maps").read_text().count("followspot-slots")


@pytest.mark.parametrize(("smallest", "pages"), [(1, 1), (4096, 1), (4097, 2), (8192, 2), (3 * 4096, 4)])
def test_a_slot_takes_the_next_power_of_two_in_whole_pages(smallest: int, pages: int) -> None:
    assert Slots(0, 2, smallest).arena.capacity == max(pages * 4096, mmap.PAGESIZE)


def test_arrays_are_read_only_views_in_shared_memory(ring: Ring) -> None:
    loan = ring.loan(SHAPE, "u1")
    loan[:] = 9
    ring.writer.send(frame(0, loan))
    message = messages(ring.readers[0].poll())[0]
    assert isinstance(message, Frame)
    with pytest.raises(ValueError, match="read-only"):
        message.pixels[0, 0, 0] = 1
    with pytest.raises(ValueError, match="cannot set WRITEABLE"):
        message.pixels.flags.writeable = True


def test_a_loan_is_sent_in_place(ring: Ring) -> None:
    """A change behind the seal, which nobody may make, shows at the reader: it is the same memory."""
    loan = ring.loan(SHAPE, "u1")
    behind = loan.view()
    loan[:] = 1
    ring.writer.send(frame(0, loan))
    message = messages(ring.readers[0].poll())[0]
    behind[:] = 2
    assert isinstance(message, Frame)
    assert (message.pixels == 2).all()


def test_a_loan_can_be_sent_in_place_once_and_by_copy_again(ring: Ring) -> None:
    loan = ring.loan(SHAPE, "u1")
    behind = loan.view()
    behind[:] = 1
    ring.writer.send(frame(0, loan))
    ring.writer.send(frame(1, loan))
    behind[:] = 2
    first, second = messages(ring.readers[0].poll())
    assert isinstance(first, Frame)
    assert isinstance(second, Frame)
    assert (first.pixels == 2).all()
    assert (second.pixels == 1).all()


def test_an_unsent_loan_returns_when_it_dies(ring: Ring) -> None:
    places = set()
    for _ in range(20):
        loan = ring.loan(SHAPE, "u1")
        places.add(address(loan))
        del loan
    assert len(places) == 1


def test_loans_that_died_do_not_count(ring: Ring) -> None:
    loans = [ring.loan(SHAPE, "u1") for _ in range(DEPTH + 1)]
    assert ring.writer.loan(SHAPE, "u1") is None
    loans.clear()
    assert ring.writer.loan(SHAPE, "u1") is not None


def test_hoarded_loans_come_to_an_end_and_never_take_the_credit(ring: Ring) -> None:
    found = [ring.writer.loan(SHAPE, "u1") for _ in range(3 * DEPTH)]
    loans = [loan for loan in found if loan is not None]
    assert 0 < len(loans) < len(found)
    assert len({address(loan) for loan in loans}) == len(loans)
    for number, loan in enumerate(loans):
        loan[:] = number
    for number in range(5 * DEPTH):
        assert ring.writer.credit() > 0
        ring.writer.send(frame(number))
        message = messages(ring.readers[0].poll())[0]
        assert identical(message, frame(number))
        ring.readers[0].consumed()
    assert all((loan == number).all() for number, loan in enumerate(loans))


def test_small_arrays_are_not_lent_for_they_travel_in_the_datagram(ring: Ring) -> None:
    assert ring.writer.loan((10, 10), "f8") is None


def test_a_loan_is_not_reused_while_this_process_keeps_the_message(ring: Ring) -> None:
    loan = ring.loan(SHAPE, "u1")
    loan[:] = 7
    kept = frame(0, loan)
    ring.writer.send(kept)
    del loan
    for number in range(1, 50):
        ring.readers[0].poll()
        ring.readers[0].consumed()
        again = ring.loan(SHAPE, "u1")
        again[:] = number
        ring.writer.send(frame(number, again))
    assert (kept.pixels == 7).all()


def test_other_arrays_of_a_message_do_not_overwrite_its_loan() -> None:
    """Both arrays are views of one loan; the second is not where it would be put behind the first."""
    ring = Ring(kind=Stereo)
    for side in (40, 64):  # with room behind the loan, and without
        loan = ring.loan((4, side, 64), "u1")
        loan[:] = np.arange(4)[:, None, None]
        ring.writer.send(stamped(seal(Stereo(loan[3], loan[0])), Header("", 0, 0)))
        message = messages(ring.readers[0].poll())[0]
        ring.readers[0].consumed()
        assert isinstance(message, Stereo)
        assert (message.left == 3).all()
        assert (message.right == 0).all()
        assert (loan == np.arange(4)[:, None, None]).all()
    ring.close()


def test_a_reader_that_keeps_every_message_never_stalls_or_changes_them(shared: Ring) -> None:
    """Over its share of slots it gets copies; the other readers do not notice."""
    kept: list[Message] = []
    for number in range(100):
        assert shared.writer.credit() > 0
        shared.writer.send(frame(number))
        for reader in shared.readers:
            arrived = messages(reader.poll())
            if reader is not shared.readers[1] or number % 3:
                kept += arrived
            reader.consumed()
    del arrived
    assert all(identical(message, frame(message.header.seq)) for message in kept)


def test_slots_come_back_when_the_last_view_dies(ring: Ring) -> None:
    for number in range(DEPTH):
        ring.writer.send(frame(number))
    arrived = messages(ring.readers[0].poll())
    rows = [message.pixels[3] for message in arrived if isinstance(message, Frame)]
    ring.readers[0].consumed(DEPTH)
    arrived.clear()
    for number in range(100, 150):
        ring.writer.send(frame(number))
        ring.readers[0].poll()
        ring.readers[0].consumed()
    assert [int(row[0, 0]) for row in rows] == list(range(DEPTH))


def test_a_reader_that_left_releases_its_slot_when_the_last_view_dies(ring: Ring) -> None:
    """A reader that nothing refers to any more still releases its slots."""
    ring.writer.send(frame(0))
    reader = ring.readers.pop()
    (message,) = messages(reader.poll())
    reader.consumed()
    ring.writer.dismiss(0)
    reader.close()
    del reader
    gc.collect()
    slots = ring.writer._pool
    assert slots is not None
    free = slots.find_free(ring.writer._links.holding)
    del message
    assert slots.find_free(ring.writer._links.holding) == free + 1


def test_a_larger_message_brings_larger_slots_and_leaves_the_old_ones_to_their_holders(ring: Ring) -> None:
    kept = []
    for number, side in enumerate((40, 100, 30, 400, 1000, 20)):
        ring.writer.send(frame(number, np.full((side, side, 3), number, np.uint8)))
        kept += messages(ring.readers[0].poll())
        ring.readers[0].consumed()
    for number, message in enumerate(kept):
        assert isinstance(message, Frame)
        assert (message.pixels == number).all()


@contextmanager
def no_more_files() -> Iterator[None]:
    """This process can open no file and take no descriptor."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    free = os.dup(0)
    os.close(free)
    resource.setrlimit(resource.RLIMIT_NOFILE, (free, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


def test_a_reader_that_can_open_no_more_files_says_so(ring: Ring) -> None:
    """The system leaves a descriptor out without an error; the messages in that memory would never come."""
    ring.writer.send(frame(0))
    ring.readers[0].poll()
    ring.writer.send(frame(1, np.zeros((100, 100, 3), np.uint8)))
    with no_more_files(), pytest.raises(FollowspotError, match=r"Too many open files\n.*ulimit -n"):
        ring.readers[0].poll()


def test_nothing_is_left_when_both_ends_are_gone(ring: Ring) -> None:
    """The memory is unmapped when the last view dies: no reference cycle keeps it."""
    gc.disable()
    before = mapped_slots()
    try:
        ring.writer.send(frame(0))
        message = messages(ring.readers.pop().poll())[0]
        ring.close()
        ring.writer = RingWriter([], DEPTH)
        assert mapped_slots() == before + 1
        assert identical(message, frame(0))
        del message
        assert mapped_slots() == before
    finally:
        gc.enable()
