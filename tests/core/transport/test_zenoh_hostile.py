"""Control tokens that a real session puts on the keys of an edge: well-formed or not, with extreme numbers.

Whatever comes is refused and counted, and a good message still passes afterwards.
"""

from __future__ import annotations

import pytest
from tests.core.transport.zenoh_pair import DEPTH, KEY, SAID, Pair, arrived, frame, until

from followspot.messages import MAX_SEQ, MAX_TIME, Header, identical, stamped
from followspot.transport.codec import pack
from followspot.transport.token import ABSENT, END, MAX_COUNT, MAX_WATERMARK, Invalid, Watermark
from followspot.transport.zenoh.terms import CREDIT, NUMBER, START, WINDOW

READER = "color%2Fcam0.frame"
EXTREME = (2**63, 2**64 - 1, 2**63 - 1, MAX_COUNT + 1)


def alive(pair: Pair) -> None:
    """A good message still passes, and its credit comes back."""
    pair.writer.send(frame(7))
    (token,) = arrived(pair.reader, 1)
    assert not isinstance(token, Watermark | Invalid)
    assert identical(token, frame(7))
    pair.reader.consumed()
    until(lambda: pair.writer.credit() == DEPTH)


@pytest.mark.parametrize("number", EXTREME)
@pytest.mark.parametrize("place", range(4))
def test_a_start_with_an_extreme_number_is_refused_and_counted(pair: Pair, place: int, number: int) -> None:
    numbers = [0, 0, 0, 0]
    numbers[place] = number
    pair.intruder(f"{KEY}/start/{READER}/0").put(START.pack(*numbers))
    until(lambda: pair.reader.poll() == [] and pair.reader.rejected == 1)
    alive(pair)


@pytest.mark.parametrize(
    "start",
    [b"", bytes(31), bytes(33), START.pack(0, 9, 10, 0), START.pack(0, 10, 5, 6), START.pack(0, 0, 0, 0)],
    ids=["empty", "short", "long", "messages beyond tokens", "given beyond messages", "back to the start"],
)
def test_a_start_that_no_writer_can_mean_is_refused_and_counted(pair: Pair, start: bytes) -> None:
    for _ in range(3):
        alive(pair)
    pair.intruder(f"{KEY}/start/{READER}/0").put(start)
    until(lambda: pair.reader.poll() == [] and pair.reader.rejected == 1)
    alive(pair)


def test_a_start_that_gives_more_than_can_be_under_way_is_refused(pair: Pair) -> None:
    many = 64 * (DEPTH + WINDOW) + 1
    pair.intruder(f"{KEY}/start/{READER}/0").put(START.pack(0, many, many, many))
    until(lambda: pair.reader.poll() == [] and pair.reader.rejected == 1)
    alive(pair)


@pytest.mark.parametrize(
    "report",
    [
        b"short",
        CREDIT.pack(0, 0, 2**63, 2**63),
        CREDIT.pack(2**64 - 1, 0, 0, 0),
        CREDIT.pack(0, 0, 2, 2),
        CREDIT.pack(0, 0, 1, 0),
    ],
    ids=["short", "extreme", "incarnation", "more than was sent", "more consumed than taken"],
)
def test_a_report_that_no_reader_can_mean_gives_no_credit_and_is_counted(pair: Pair, report: bytes) -> None:
    pair.writer.send(frame(0))
    pair.intruder(f"{SAID}/credit/{READER}").put(report)
    until(lambda: pair.writer.rejected == 1)
    assert pair.writer.credit() == DEPTH - 1
    arrived(pair.reader, 1)
    pair.reader.consumed()
    alive(pair)


def test_a_report_of_an_unknown_reader_is_counted(pair: Pair) -> None:
    pair.intruder(f"{SAID}/credit/nobody").put(CREDIT.pack(0, 0, 0, 0))
    until(lambda: pair.writer.rejected == 1)
    alive(pair)


@pytest.mark.parametrize("place", ["seq", "time", "entered"])
@pytest.mark.parametrize("number", [MAX_TIME + 1, -MAX_TIME - 1, END, ABSENT, ABSENT - 1, -END])
def test_a_message_with_an_extreme_header_is_invalid(pair: Pair, place: str, number: int) -> None:
    bad = stamped(frame(1), frame(1).header._replace(**{place: number}))
    pair.intruder(KEY).put(pack(bad), attachment=NUMBER.pack(0, 0, 1))
    (token,) = arrived(pair.reader, 1)
    assert isinstance(token, Invalid)
    assert "header" in token.reason


@pytest.mark.parametrize("seq", [0, MAX_SEQ])
@pytest.mark.parametrize("time", [-MAX_TIME, MAX_TIME])
def test_the_ends_of_the_range_pass(pair: Pair, seq: int, time: int) -> None:
    given = stamped(frame(1), Header("camera/cam0", seq, time, time))
    pair.writer.send(given)
    (token,) = arrived(pair.reader, 1)
    assert not isinstance(token, Watermark | Invalid)
    assert identical(token, given)


@pytest.mark.parametrize("time", [MAX_WATERMARK + 1, ABSENT - 1, -MAX_WATERMARK - 1, -END])
def test_a_bound_that_no_message_leads_to_is_refused(pair: Pair, time: int) -> None:
    pair.intruder(KEY).put(pack(Watermark(time)), attachment=NUMBER.pack(0, 0, 1))
    (token,) = arrived(pair.reader, 1)
    assert isinstance(token, Invalid)


@pytest.mark.parametrize("time", [MAX_WATERMARK, -MAX_WATERMARK, ABSENT, END])
def test_bounds_within_the_range_the_absence_and_the_end_pass(pair: Pair, time: int) -> None:
    pair.writer.send(Watermark(time))
    assert arrived(pair.reader, 1) == [Watermark(time)]
