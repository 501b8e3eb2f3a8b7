"""What is particular to Zenoh: strangers on the network, sessions, one session with both ends."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import NamedTuple

import numpy as np
import pytest
import zenoh
from tests.integration.hosts import free_port

from followspot.errors import FollowspotError
from followspot.messages import Header, Message, identical, stamped
from followspot.sealing import seal
from followspot.tracking import Blobs, Frame
from followspot.transport.codec import pack
from followspot.transport.keys import reader_key
from followspot.transport.token import END, MAX_WATERMARK, Invalid, Token, Watermark
from followspot.transport.wakeup_event import WakeupEvent
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter, locators, open_session
from followspot.transport.zenoh.terms import CREDIT, KNOWN, NUMBER, WINDOW

KEY = "test/camera/cam0/out"
NAME = "color/cam0.frame"
SAID = reader_key(KEY, "")
QUOTED = "color%2Fcam0.frame"
DEPTH = 4


class Pair:
    """Both ends in one session, and a stranger's session beside it."""

    def __init__(self) -> None:
        self._sessions = ExitStack()
        self.session = self._sessions.enter_context(open_session())
        self.stranger = self._sessions.enter_context(open_session(connect=locators(self.session)))
        self.writer = ZenohWriter(self.session, KEY, {NAME: ""}, DEPTH)
        self.reader = ZenohReader(self.session, KEY, NAME, Frame, DEPTH)
        until(lambda: all([self.writer.matched(), self.reader.matched()]))

    def intruder(self, key: str) -> zenoh.Publisher:
        """A stranger's publisher whose samples will arrive."""
        publisher = self.stranger.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK)
        until(lambda: bool(publisher.matching_status.matching))  # type: ignore[attr-defined]
        return publisher

    def finished(self) -> bool:
        """Whether the reader has all, up to the end."""
        self.writer.drain()
        return self.writer.flush()

    def close(self) -> None:
        self.writer.close()
        self.reader.close()
        self._sessions.close()


@pytest.fixture
def pair() -> Iterator[Pair]:
    made = Pair()
    yield made
    made.close()


def until(condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < limit, "it never happened"
        time.sleep(0.005)


def arrived(reader: ZenohReader, count: int) -> list[Token]:
    tokens: list[Token] = []

    def enough() -> bool:
        tokens.extend(reader.poll())
        return len(tokens) >= count

    until(enough)
    return tokens


def frame(number: int) -> Frame:
    pixels = np.full((30, 40, 3), number, np.uint8)
    return stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", number, number))


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


def test_what_strangers_put_on_the_key_is_passed_over_and_counted(pair: Pair) -> None:
    intruder = pair.intruder(KEY)
    intruder.put(b"hello")
    intruder.put(b"", attachment=b"")
    intruder.put(pack(frame(9)), attachment=NUMBER.pack(0, 10**6, 10**6))
    intruder.put(pack(frame(9)), attachment=NUMBER.pack(0, 0, 0))
    intruder.put(pack(frame(9)), attachment=NUMBER.pack(0, 0, 9))
    intruder.put(b"nonsense", attachment=NUMBER.pack(0, 0, 0))
    until(lambda: len(pair.reader._arrived) == 6)
    pair.writer.send(frame(0))
    intruder.put(pack(frame(9)), attachment=NUMBER.pack(0, 0, 1))
    pair.writer.send(frame(1))
    tokens = arrived(pair.reader, 2)
    assert all(isinstance(token, Message) and identical(token, frame(n)) for n, token in enumerate(tokens))
    until(lambda: pair.reader.poll() == [] and pair.reader.rejected == 7)


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


def test_a_flood_from_a_stranger_fills_no_memory(pair: Pair) -> None:
    publisher = pair.intruder(KEY)
    for _ in range(2000):
        publisher.put(bytes(1000))
    publisher.put(bytes(1000), attachment=b"last")
    until(lambda: len(pair.reader._arrived) == pair.reader._limit)
    until(lambda: pair.reader.poll() == [] and pair.reader.rejected == 2001)


def test_false_reports_are_counted_and_give_no_credit(pair: Pair) -> None:
    pair.writer.send(frame(0))
    pair.intruder(f"{SAID}/credit/nobody").put(CREDIT.pack(0, 0, 5, 5))
    reports = pair.intruder(f"{SAID}/credit/{QUOTED}")
    reports.put(b"short")
    reports.put(CREDIT.pack(0, 0, 2**63, 2**63))
    until(lambda: pair.writer.rejected == 3)
    assert pair.writer.credit() == DEPTH - 1


def test_a_writer_believes_of_a_reader_only_what_its_own_host_says(pair: Pair) -> None:
    """Neither credit, nor that it is there again, nor that it is done, nor that it went."""
    for number in range(DEPTH):
        pair.writer.send(frame(number))
    arrived(pair.reader, DEPTH)
    elsewhere = reader_key(KEY, "pc-left")
    pair.intruder(f"{elsewhere}/credit/{QUOTED}").put(CREDIT.pack(0, 0, DEPTH, DEPTH))
    tokens = [
        pair.stranger.liveliness().declare_token(f"{elsewhere}/{words.format(QUOTED)}")
        for words in ("alive/{0}/0", "alive/{0}/1", "done/{0}/0/0", "done/{0}/1/0")
    ]
    until(lambda: pair.writer.rejected == 1 + len(tokens))
    for token in tokens:
        token.undeclare()  # type: ignore[no-untyped-call]
    own = pair.stranger.liveliness().declare_token(f"{SAID}/done/{QUOTED}/0/0")
    until(lambda: bool(pair.writer._flow._changes))
    own.undeclare()  # type: ignore[no-untyped-call]
    assert pair.writer.credit() == 0
    pair.writer.drain()
    assert pair.writer.lost == frozenset()
    (reader,) = pair.writer._flow.readers
    assert reader.done, "it was its own host that said so"
    assert reader.present
    assert reader.incarnation == 0
    assert pair.writer.rejected == 1 + len(tokens)


@pytest.mark.parametrize(
    "words",
    [
        "alive/{0}/x",
        "alive/{0}/-1",
        "alive/{0}/1e3",
        "alive/{0}/٣",
        "alive/{0}/" + "9" * 5000,
        "dead/{0}/1",
        "done/{0}/1",
        "done/{0}/1/x",
        "done/{0}/x/0",
        "done/nobody/1/0",
        "alive/nobody/1",
    ],
)
def test_a_token_that_tells_nothing_is_refused_and_counted(pair: Pair, words: str) -> None:
    token = pair.stranger.liveliness().declare_token(f"{SAID}/{words.format(QUOTED)}")
    until(lambda: pair.writer.rejected == 1)
    token.undeclare()  # type: ignore[no-untyped-call]
    pair.writer.send(frame(0))
    assert arrived(pair.reader, 1)
    assert not pair.writer._flow._changes
    assert pair.writer.rejected == 1
    assert not pair.writer.lost


@pytest.mark.parametrize("incarnation", ["x", "-1", "9" * 5000, "*"])
def test_a_writers_token_that_tells_nothing_is_refused_and_counted(pair: Pair, incarnation: str) -> None:
    token = pair.stranger.liveliness().declare_token(f"{KEY}/alive/writer/{incarnation}")
    until(lambda: pair.reader.rejected == 1)
    pair.writer.close()
    until(lambda: pair.reader._gone)
    token.undeclare()  # type: ignore[no-untyped-call]


def test_a_writers_token_that_a_stranger_takes_back_keeps_no_later_writer_away(pair: Pair) -> None:
    token = pair.stranger.liveliness().declare_token(f"{KEY}/alive/writer/88")
    until(lambda: 88 in pair.reader._there)
    token.undeclare()  # type: ignore[no-untyped-call]
    until(lambda: 88 not in pair.reader._there)
    assert not pair.reader.lost, "the true writer is there"
    pair.writer.close()
    pair.writer = ZenohWriter(pair.session, KEY, {NAME: ""}, DEPTH, incarnation=1)
    until(lambda: not pair.reader.poll() and pair.writer.matched())
    pair.writer.send(frame(7))
    (arrival,) = arrived(pair.reader, 1)
    assert isinstance(arrival, Message)
    assert identical(arrival, frame(7))


def test_what_strangers_put_on_all_keys_at_once_kills_nobody(
    pair: Pair, capfd: pytest.CaptureFixture[str]
) -> None:
    pair.stranger.put("**", b"hello")
    pair.stranger.put("test/**", CREDIT.pack(0, 0, 1, 1))
    token = pair.stranger.liveliness().declare_token("**")
    until(lambda: pair.writer.rejected >= 2)
    until(lambda: pair.reader.poll() == [] and pair.reader.rejected >= 2)
    pair.writer.send(frame(0))
    arrived(pair.reader, 1)
    token.undeclare()  # type: ignore[no-untyped-call]
    assert "Traceback" not in capfd.readouterr().err


def test_a_session_on_an_endpoint_that_is_taken_or_nonsense_says_so(pair: Pair) -> None:
    for endpoint in (*locators(pair.session), "carrier-pigeon/roof"):
        with pytest.raises(FollowspotError, match="Zenoh cannot use") as told:
            open_session([endpoint])
        assert ".rs:" not in str(told.value)


def test_by_default_only_this_host_is_reached(pair: Pair) -> None:
    assert all(locator.startswith("tcp/127.0.0.1:") for locator in locators(pair.session))


def test_peers_may_start_in_any_order() -> None:
    place = f"tcp/127.0.0.1:{free_port()}"
    with open_session(connect=[place]) as early, open_session([place]):
        until(lambda: len(early.info.peers_zid()) == 1)


def test_peers_of_one_peer_find_each_other() -> None:
    with ExitStack() as sessions:
        hub = sessions.enter_context(open_session())
        spokes = [sessions.enter_context(open_session(connect=locators(hub))) for _ in range(3)]
        until(lambda: all(len(spoke.info.peers_zid()) == 3 for spoke in spokes))


def test_closing_twice_or_after_the_session_harms_nobody(pair: Pair) -> None:
    pair.session.close()  # type: ignore[no-untyped-call]
    pair.writer.send(Watermark(5))
    pair.reader.consumed()
    for _ in range(2):
        pair.writer.close()
        pair.reader.close()


def test_a_process_that_closes_its_edges_exits() -> None:
    script = (
        "from followspot.transport.zenoh.edge import *; from followspot.tracking import Frame;"
        "session = open_session(); writer = ZenohWriter(session, 'k', {'r': ''}, 4);"
        "reader = ZenohReader(session, 'k', 'r', Frame, 4); writer.close(); reader.close(); session.close()"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=30)


def test_a_signal_handler_may_set_a_wakeup_event_that_its_thread_is_closing() -> None:
    wakeup = WakeupEvent()

    def interrupted() -> None:
        with wakeup._lock:  # as `close` does
            wakeup.set()
        wakeup.close()

    closing = threading.Thread(target=interrupted, daemon=True)
    closing.start()
    closing.join(20)
    assert not closing.is_alive()


def test_a_closed_wakeup_event_does_not_touch_the_next_owner_of_its_descriptor() -> None:
    wakeup = WakeupEvent()
    number = wakeup.fileno()
    wakeup.close()
    other = WakeupEvent()
    assert other.fileno() == number
    wakeup.set()
    with pytest.raises(BlockingIOError):
        os.eventfd_read(number)
    other.close()


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
