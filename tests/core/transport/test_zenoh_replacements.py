"""Ends of Zenoh edges in whose place others came: who is believed, what is told, what is accounted for."""

from __future__ import annotations

from typing import Any, cast

import pytest
import zenoh
from tests.core.transport.zenoh_pair import DEPTH, KEY, NAME, QUOTED, SAID, Pair, arrived, frame, until

from followspot.messages import identical
from followspot.tracking import Frame
from followspot.transport.codec import pack
from followspot.transport.token import ABSENT, END, Invalid, Watermark
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter, open_session
from followspot.transport.zenoh.terms import CREDIT, NUMBER, START


def replacement(pair: Pair, incarnation: int = 1) -> ZenohWriter:
    """A writer that takes the place of the one that is there still."""
    writer = ZenohWriter(pair.session, KEY, {NAME: ""}, DEPTH, incarnation=incarnation)

    def joined() -> bool:
        writer.drain()
        pair.reader.poll()
        return not writer.lost and writer.matched()

    until(joined)
    return writer


def test_a_writer_whose_place_was_taken_leaves_without_taking_the_reader_along(pair: Pair) -> None:
    """It was on a host that nobody heard from; the news of its end comes late."""
    new = replacement(pair)
    until(lambda: pair.reader.poll() == [] and pair.reader.position.writer == 1)
    pair.writer.close()
    until(lambda: bool(pair.reader._arrived))
    new.send(frame(7))
    (message,) = arrived(pair.reader, 1)
    assert identical(message, frame(7))  # type: ignore[arg-type]
    assert not pair.reader.lost
    new.close()
    until(lambda: pair.reader.poll() == [] and pair.reader.lost)


def test_a_writer_that_is_gone_is_lost_though_one_before_it_is_still_there(pair: Pair) -> None:
    replacement(pair).close()
    until(lambda: pair.reader.poll() == [] and pair.reader.lost)


def test_a_writer_whose_place_was_taken_is_not_listened_to(pair: Pair) -> None:
    new = replacement(pair)
    until(lambda: pair.reader.poll() == [] and pair.reader.position.writer == 1)
    pair.writer._send_start(pair.writer._flow.readers[0])
    pair.writer.send(frame(1))
    new.send(frame(2))
    (message,) = arrived(pair.reader, 1)
    assert identical(message, frame(2))  # type: ignore[arg-type]
    new.close()


def test_a_reader_whose_place_was_taken_is_not_believed(pair: Pair) -> None:
    """Neither its presence, nor its going, nor what it says to have consumed."""
    pair.reader.close()
    pair.reader = ZenohReader(pair.session, KEY, NAME, Frame, DEPTH, incarnation=1)

    def matched() -> bool:
        pair.writer.drain()
        return all([pair.writer.matched(), pair.reader.matched()])

    until(matched)
    for number in range(DEPTH):
        pair.writer.send(frame(number))
    assert len(arrived(pair.reader, DEPTH)) == DEPTH
    ghost = pair.session.liveliness().declare_token(f"{SAID}/alive/{QUOTED}/0")
    pair.session.put(f"{SAID}/credit/{QUOTED}", CREDIT.pack(0, 0, DEPTH, DEPTH))
    until(lambda: bool(pair.writer._flow._changes))
    pair.writer.drain()
    assert pair.writer.credit() == 0
    ghost.undeclare()  # type: ignore[no-untyped-call]
    until(lambda: bool(pair.writer._flow._changes))
    pair.writer.drain()
    assert not pair.writer.lost
    pair.reader.consumed(DEPTH)
    until(lambda: pair.writer.credit() == DEPTH)
    pair.writer.send(Watermark(END))
    assert not pair.writer.flush(), "the one that is there has not taken the end"
    arrived(pair.reader, 1)
    until(pair.finished)


def test_a_stream_that_has_ended_begins_again_with_the_writer_that_comes_later(pair: Pair) -> None:
    """And ends again: that the reader took an end before says nothing of this one."""
    pair.writer.send(Watermark(END))
    arrived(pair.reader, 1)
    until(pair.finished)
    pair.writer.close()
    until(lambda: pair.reader.poll() == [] and pair.reader._gone)
    assert not pair.reader.lost
    pair.writer = replacement(pair)
    for number in range(3 * DEPTH):
        until(lambda: pair.writer.credit() > 0)
        pair.writer.send(frame(number))
        (message,) = arrived(pair.reader, 1)
        assert identical(message, frame(number))  # type: ignore[arg-type]
        pair.reader.consumed()
    pair.writer.send(Watermark(END))
    assert not pair.writer.flush()
    assert arrived(pair.reader, 1) == [Watermark(END)]
    until(pair.finished)


def test_a_reader_that_replaces_one_that_took_the_end_takes_it_too(pair: Pair) -> None:
    pair.writer.send(Watermark(END))
    arrived(pair.reader, 1)
    until(pair.finished)
    pair.reader.close()
    pair.reader = ZenohReader(pair.session, KEY, NAME, Frame, DEPTH, incarnation=1)
    until(lambda: len(pair.writer._flow._changes) >= 2)
    assert not pair.finished()
    assert arrived(pair.reader, 1) == [Watermark(END)]
    until(pair.finished)


def test_messages_that_a_reader_was_given_before_it_was_told_where_to_start_are_missing() -> None:
    """The link swallowed the first word; the second one says how many there were."""
    pair = Pair()
    late = ZenohReader(pair.session, f"{KEY}/late", NAME, Frame, DEPTH)
    pair.intruder(f"{KEY}/late/start/{QUOTED}/0").put(START.pack(0, 3, 2, 2))
    assert all(isinstance(token, Invalid) for token in arrived(late, 2))
    late.close()
    pair.close()


@pytest.mark.parametrize(("given", "missing"), [(3, 0), (2, 0), (9, 6)])
def test_after_a_cut_as_many_are_missing_as_were_given_and_did_not_come(
    pair: Pair, given: int, missing: int
) -> None:
    for n in range(3):
        pair.writer.send(frame(n))
        arrived(pair.reader, 1)
    pair.intruder(f"{KEY}/start/{QUOTED}/0").put(START.pack(0, 12, 11, given))
    pair.intruder(KEY).put(pack(frame(7)), attachment=NUMBER.pack(0, 12, 12))
    *gaps, token = arrived(pair.reader, missing + 1)
    assert gaps == [Invalid("gap: it was on its way when the link was cut", missing=True)] * missing
    assert not isinstance(token, Watermark | Invalid)
    assert identical(token, frame(7))
    assert pair.reader.rejected == 0


@pytest.mark.parametrize("time", [5, ABSENT, END])
def test_a_reader_that_comes_later_is_told_the_last_watermark(pair: Pair, time: int) -> None:
    pair.writer.send(Watermark(time))
    arrived(pair.reader, 1)
    pair.reader.close()
    pair.reader = ZenohReader(pair.session, KEY, NAME, Frame, DEPTH, incarnation=1)
    until(lambda: len(pair.writer._flow._changes) >= 2)
    pair.writer.drain()
    assert arrived(pair.reader, 1) == [Watermark(time)]


def test_the_end_comes_to_a_reader_that_was_flooded_when_it_was_told(pair: Pair) -> None:
    flood = pair.intruder(KEY)
    for _ in range(pair.reader._limit):
        flood.put(b"")
    until(lambda: len(pair.reader._arrived) == pair.reader._limit)
    pair.writer.send(frame(0))
    pair.writer.send(Watermark(END))
    missing, end = arrived_while_writing(pair, 2)
    assert isinstance(missing, Invalid)
    assert end == Watermark(END)
    until(pair.finished)


def arrived_while_writing(pair: Pair, count: int) -> list[object]:
    found: list[object] = []

    def enough() -> bool:
        pair.writer.drain()
        found.extend(pair.reader.poll())
        return len(found) >= count

    until(enough)
    return found


def test_what_a_writer_tells_a_reader_is_not_for_the_one_that_takes_its_place(pair: Pair) -> None:
    """A writer told a dead reader again where to start; the next reader took that and missed messages."""
    pair.writer.send(frame(0))
    late = ZenohReader(pair.session, KEY, NAME, Frame, DEPTH, incarnation=1)
    until(lambda: bool(pair.writer._flow._changes))
    pair.writer._send_start(pair.writer._flow.readers[0])
    pair.writer.drain()
    pair.writer.send(frame(1))
    (message,) = arrived(late, 1)
    assert identical(message, frame(1))  # type: ignore[arg-type]
    late.close()


def test_the_end_that_a_replaced_reader_takes_late_does_not_count_for_the_present_one(pair: Pair) -> None:
    """The writer left then, although the present reader had not taken the end."""
    pair.writer.send(Watermark(END))
    present = ZenohReader(pair.session, KEY, NAME, Frame, DEPTH, incarnation=1)

    def told() -> bool:
        pair.writer.drain()
        return bool(present._arrived)

    until(told)
    until(lambda: Watermark(END) in pair.reader.poll())
    until(lambda: bool(pair.writer._flow._changes))
    assert not pair.finished()
    until(lambda: Watermark(END) in present.poll())
    until(pair.finished)
    present.close()


class Answered:
    """A session through which a writer speaks, and whose put returns when the readers have answered."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self.readers: list[ZenohReader] = []
        self.heard: set[str] = set()
        self._declared = session.declare_subscriber(f"{SAID}/credit/*", self._on_report)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._session, name)

    def put(self, key: str, payload: bytes, **options: Any) -> None:
        self._session.put(key, payload, **options)
        if self.readers:
            answers = [reader.matched() for reader in self.readers]
            assert all(answers)
            until(lambda: len(self.heard) == len(self.readers))

    def _on_report(self, sample: zenoh.Sample) -> None:
        self.heard.add(str(sample.key_expr))


def test_readers_may_answer_while_a_writer_tells_all_of_them_again_where_they_start() -> None:
    """It raised, for their answers came from a thread of Zenoh into the set that it went through."""
    with open_session() as session:
        answered = Answered(session)
        names = ("left", "right")
        writer = ZenohWriter(cast(zenoh.Session, answered), KEY, dict.fromkeys(names, ""), DEPTH)
        readers = [ZenohReader(session, KEY, name, Frame, DEPTH) for name in names]

        def joined() -> bool:
            writer.drain()
            return all(reader._arrived for reader in readers)

        until(joined)
        answered.readers = readers
        until(writer.matched)
        assert answered.heard
        for end in (writer, *readers):
            end.close()
        answered._declared.undeclare()  # type: ignore[no-untyped-call]
