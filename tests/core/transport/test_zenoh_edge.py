"""The two ends of a Zenoh edge: readers that come, go and are cut off, credit and watermarks."""

from __future__ import annotations

from typing import NamedTuple

import pytest
import zenoh
from tests.core.transport.zenoh_pair import DEPTH, KEY, NAME, QUOTED, SAID, Pair, arrived, frame, until

from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, identical, stamped
from followspot.tracking import Blobs, Frame
from followspot.transport.codec import pack
from followspot.transport.token import END, MAX_WATERMARK, Invalid, Watermark
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter
from followspot.transport.zenoh.terms import KNOWN, NUMBER, WINDOW


def test_both_ends_may_share_a_session(pair: Pair) -> None:
    for number in range(DEPTH):
        pair.writer.send(frame(number))
    pair.writer.send(Watermark(END))
    assert pair.writer.credit() == 0
    tokens = arrived(pair.reader, DEPTH + 1)
    assert all(isinstance(t, Message) and identical(t, frame(n)) for n, t in enumerate(tokens[:DEPTH]))
    pair.reader.consumed(DEPTH)
    until(lambda: pair.writer.credit() == DEPTH)
    until(pair.finished)
    assert not pair.writer.lost
    assert not pair.reader.lost


def test_the_writer_is_not_done_before_the_end_was_read(pair: Pair) -> None:
    pair.writer.send(Watermark(END))
    assert not pair.writer.flush()
    arrived(pair.reader, 1)
    until(pair.finished)
    pair.writer.close()
    until(lambda: pair.reader._gone)
    assert not pair.reader.lost


def test_only_a_drain_finds_readers_gone_or_back_for_who_counts_asks_after_it(pair: Pair) -> None:
    for lost in (frozenset({0}), frozenset()):
        known = pair.writer.lost
        if lost:
            pair.reader.close()
        else:
            pair.reader = ZenohReader(pair.session, KEY, NAME, Frame, DEPTH, incarnation=1)
        until(lambda: bool(pair.writer._flow._changes))
        pair.writer.flush()
        pair.writer.credit()
        assert pair.writer.lost == known
        pair.writer.drain()
        assert pair.writer.lost == lost


def test_what_was_on_its_way_to_a_reader_is_lost_when_another_one_comes_and_not_before(pair: Pair) -> None:
    for number in range(3):
        pair.writer.send(frame(number))
    arrived(pair.reader, 3)
    pair.reader.consumed()
    until(lambda: pair.writer.credit() == DEPTH - 2)
    pair.reader.close()
    until(lambda: drained(pair.writer).lost == frozenset({0}))
    pair.writer.send(frame(3))  # nobody is there to lose it
    assert pair.writer.newly_dead() == []
    pair.reader = ZenohReader(pair.session, KEY, NAME, Frame, DEPTH, incarnation=1)
    until(lambda: drained(pair.writer).lost == frozenset())
    assert pair.writer.newly_dead() == [(0, 2)]
    assert pair.writer.newly_dead() == []


def test_what_was_on_its_way_to_a_reader_that_was_only_cut_off_is_not_lost(pair: Pair) -> None:
    """It finds a gap when it is back."""
    pair.writer.send(frame(0))
    pair.writer._flow.take_presence(Presence(zenoh.SampleKind.DELETE))  # type: ignore[arg-type]
    assert drained(pair.writer).lost == frozenset({0})
    pair.writer._flow.take_presence(Presence(zenoh.SampleKind.PUT))  # type: ignore[arg-type]
    assert drained(pair.writer).lost == frozenset()
    assert pair.writer.newly_dead() == []


def test_what_was_on_its_way_to_a_reader_that_was_cut_off_to_the_end_is_lost(pair: Pair) -> None:
    pair.writer.send(frame(0))
    pair.writer._flow.take_presence(Presence(zenoh.SampleKind.DELETE))  # type: ignore[arg-type]
    assert drained(pair.writer).lost == frozenset({0})
    pair.writer.close()
    assert pair.writer.newly_dead() == [(0, 1)]


def test_a_reader_that_is_said_to_be_there_and_has_no_token_is_found_missing(pair: Pair) -> None:
    """Zenoh says so at times to a writer that comes while the reader leaves, and never takes it back."""
    pair.reader.close()
    until(lambda: drained(pair.writer).lost == frozenset({0}))
    pair.writer._flow.take_presence(Presence(zenoh.SampleKind.PUT))  # type: ignore[arg-type]
    assert drained(pair.writer).lost == frozenset()
    pair.writer.send(frame(0))

    def found_missing() -> bool:
        pair.writer.flush()  # as an idle worker does
        return drained(pair.writer).lost == frozenset({0})

    until(found_missing)


def test_a_reader_that_is_there_and_does_not_report_is_waited_for(pair: Pair) -> None:
    pair.reader.close()
    until(lambda: drained(pair.writer).lost == frozenset({0}))
    token = pair.stranger.liveliness().declare_token(f"{SAID}/alive/{QUOTED}/1")
    until(lambda: drained(pair.writer).lost == frozenset())
    sent_at = {pair.writer._start_sent_at}

    def told_again() -> bool:
        pair.writer.flush()
        sent_at.add(pair.writer._start_sent_at)
        return len(sent_at) > 3

    until(told_again)
    assert drained(pair.writer).lost == frozenset()
    token.undeclare()
    until(lambda: drained(pair.writer).lost == frozenset({0}))


def drained(writer: ZenohWriter) -> ZenohWriter:
    writer.drain()
    return writer


class Presence(NamedTuple):
    """What Zenoh tells of a reader's liveliness token."""

    kind: zenoh.SampleKind
    key_expr: str = f"{SAID}/alive/{QUOTED}/0"


def test_a_message_without_credit_is_a_mistake_of_the_caller(pair: Pair) -> None:
    for number in range(DEPTH):
        pair.writer.send(frame(number))
    with pytest.raises(RuntimeError, match="credit"):
        pair.writer.send(frame(DEPTH))


def test_lost_and_broken_messages_are_invalid_in_their_place(pair: Pair) -> None:
    """A stranger takes the numbers of the writer: two are skipped, the third is of another type."""
    blobs = pack(stamped(seal(Blobs.empty()), Header("", 0, 0)))
    pair.intruder(KEY).put(blobs, attachment=NUMBER.pack(0, 2, 3))
    *missing, wrong = arrived(pair.reader, 3)
    assert missing == [Invalid("gap: it is one of 2 messages that never came", missing=True)] * 2
    assert isinstance(wrong, Invalid)
    assert "Frame" in wrong.reason


def test_watermarks_that_never_came_are_no_loss(pair: Pair) -> None:
    pair.intruder(KEY).put(pack(Watermark(7)), attachment=NUMBER.pack(0, 5, 0))
    assert arrived(pair.reader, 1) == [Watermark(7)]


def test_a_full_window_holds_back_and_merges_watermarks_in_order(pair: Pair) -> None:
    for number in range(WINDOW + 50):
        pair.writer.send(Watermark(number))
    assert pair.writer.credit() == 0
    tokens = arrived(pair.reader, WINDOW)
    until(lambda: pair.writer.credit() == DEPTH)
    pair.writer.send(frame(0))
    tokens += arrived(pair.reader, 2)
    assert tokens[: WINDOW + 1] == [*map(Watermark, range(WINDOW)), Watermark(WINDOW + 49)]
    assert isinstance(tokens[-1], Message)


def test_the_watermark_after_a_message_comes_with_it_and_one_out_of_range_is_refused(pair: Pair) -> None:
    pair.writer.send(frame(0), 7)
    message, watermark = arrived(pair.reader, 2)
    assert isinstance(message, Message)
    assert watermark == Watermark(7)
    intruder, count = pair.intruder(KEY), len(pair.reader._arrived)
    for wrong in (END, MAX_WATERMARK + 1):
        intruder.put(pack(frame(9)), attachment=NUMBER.pack(0, 1, 2) + KNOWN.pack(wrong))
    until(lambda: len(pair.reader._arrived) == count + 2)
    assert pair.reader.poll() == []
    assert pair.reader.rejected == 2
