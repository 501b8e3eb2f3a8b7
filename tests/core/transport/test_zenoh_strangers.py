"""What strangers on the network put on the keys of an edge is refused and counted."""

from __future__ import annotations

import pytest
from tests.core.transport.zenoh_pair import DEPTH, KEY, NAME, QUOTED, SAID, Pair, arrived, frame, until

from followspot.messages import Message, identical
from followspot.transport.codec import pack
from followspot.transport.keys import reader_key
from followspot.transport.zenoh.edge import ZenohWriter
from followspot.transport.zenoh.terms import CREDIT, NUMBER


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


def test_what_strangers_put_on_all_keys_at_once_kills_no_process(
    pair: Pair, capfd: pytest.CaptureFixture[str]
) -> None:
    def rejected() -> bool:
        """Whether both ends have rejected both; what is put before the stranger knows the ends is lost."""
        pair.stranger.put("**", b"hello")
        pair.stranger.put("test/**", CREDIT.pack(0, 0, 1, 1))
        return pair.reader.poll() == [] and min(pair.reader.rejected, pair.writer.rejected) >= 2

    token = pair.stranger.liveliness().declare_token("**")
    until(rejected)
    pair.writer.send(frame(0))
    arrived(pair.reader, 1)
    token.undeclare()  # type: ignore[no-untyped-call]
    assert "Traceback" not in capfd.readouterr().err
