"""What a Zenoh writer knows of its readers, and the credit that they give, without any session."""

from __future__ import annotations

from typing import NamedTuple

import pytest
from zenoh import SampleKind

from followspot.transport.keys import reader_key
from followspot.transport.zenoh.flow_control import FlowControl
from followspot.transport.zenoh.terms import CREDIT, WINDOW

DEPTH = 4
HERE = reader_key("test/port", "")


class Sample(NamedTuple):
    """What Zenoh passes to a callback."""

    key_expr: str
    payload: bytes = b""
    kind: SampleKind = SampleKind.PUT


class Payload(bytes):
    def to_bytes(self) -> bytes:
        return self


class Flow(FlowControl):
    """Flow control of two readers, both of which are there."""

    def __init__(self, incarnation: int = 0) -> None:
        self.woken = 0
        super().__init__({"near": "", "far": ""}, DEPTH, incarnation, self._count)
        for name in ("near", "far"):
            self.comes(name, 0)

    def comes(self, name: str, incarnation: int) -> None:
        self.presence(f"{HERE}/alive/{name}/{incarnation}")
        list(self.changes())

    def leaves(self, name: str, incarnation: int) -> None:
        self.presence(f"{HERE}/alive/{name}/{incarnation}", SampleKind.DELETE)
        list(self.changes())

    def presence(self, key: str, kind: SampleKind = SampleKind.PUT) -> None:
        self.take_presence(Sample(key, kind=kind))  # type: ignore[arg-type]

    def ends(self, name: str, incarnation: int, writer: int = 0) -> None:
        self.take_end(Sample(f"{HERE}/done/{name}/{incarnation}/{writer}"))  # type: ignore[arg-type]
        list(self.changes())

    def reports(self, name: str, consumed: int, taken: int, incarnation: int = 0) -> bool:
        payload = Payload(CREDIT.pack(self._incarnation, incarnation, consumed, taken))
        return self.take_report(Sample(f"{HERE}/credit/{name}", payload))  # type: ignore[arg-type]

    def put(self, messages: int) -> None:
        for _ in range(messages):
            self.count_message()
            self.tokens += 1

    def _count(self) -> None:
        self.woken += 1


def test_the_slowest_reader_bounds_the_credit() -> None:
    flow = Flow()
    flow.put(3)
    assert flow.reports("near", 3, 3)
    assert flow.reports("far", 1, 3)
    assert flow.credit() == DEPTH - 2


def test_there_is_no_credit_while_the_window_of_tokens_is_full() -> None:
    flow = Flow()
    flow.tokens = WINDOW
    assert flow.window_is_full()
    assert flow.credit() == 0
    assert flow.reports("near", 0, 1)
    assert flow.window_is_full(), "the far one has taken none"
    assert flow.reports("far", 0, 1)
    assert flow.credit() == DEPTH


def test_what_was_put_before_a_reader_came_does_not_count_for_it() -> None:
    flow = Flow()
    flow.leaves("far", 0)
    flow.put(DEPTH)
    flow.reports("near", DEPTH, DEPTH)
    flow.comes("far", 1)
    assert flow.credit() == DEPTH
    assert [reader.given for reader in flow.readers] == [DEPTH, 0]


def test_a_reader_that_is_away_is_given_no_messages() -> None:
    flow = Flow()
    flow.put(2)
    flow.leaves("far", 0)
    flow.put(1)
    flow.comes("far", 0)
    assert [reader.given for reader in flow.readers] == [3, 2]


def test_a_reader_that_has_taken_the_end_may_leave_and_is_not_lost() -> None:
    flow = Flow()
    flow.ends("far", 0)
    flow.leaves("far", 0)
    assert flow.lost == frozenset()
    flow.leaves("near", 0)
    assert flow.lost == {0}
    assert flow.ended


@pytest.mark.parametrize("incarnation", [0, 1])
def test_only_the_end_that_the_present_reader_took_counts(incarnation: int) -> None:
    flow = Flow()
    flow.comes("far", 1)
    flow.ends("far", incarnation)
    far = flow.readers[1]
    assert far.done == (incarnation == 1)


def test_an_end_that_a_replaced_reader_takes_late_takes_none_back() -> None:
    flow = Flow()
    flow.comes("far", 1)
    flow.ends("far", 1)
    flow.ends("far", 0)
    assert flow.readers[1].done


def test_the_end_may_come_before_the_news_that_its_reader_is_there() -> None:
    """A new link tells of tokens in any order."""
    flow = Flow()
    flow.ends("far", 1)
    assert not flow.readers[1].done
    flow.comes("far", 1)
    assert flow.readers[1].done


def test_the_end_of_another_writer_says_nothing_of_this_one() -> None:
    flow = Flow(incarnation=2)
    woken = flow.woken
    flow.ends("far", 0, writer=1)
    assert not flow.readers[1].done
    assert flow.woken == woken
    flow.ends("far", 0, writer=2)
    assert flow.readers[1].done
    assert flow.woken == woken + 1


def test_readers_of_a_later_writer_are_lost_until_they_come() -> None:
    flow = FlowControl({"near": "", "far": ""}, DEPTH, 1, lambda: None)
    assert flow.lost == {0, 1}
    assert Flow(incarnation=1).lost == frozenset()


def test_a_death_counts_what_was_put_until_the_reader_left_and_is_told_once() -> None:
    flow = Flow()
    flow.put(3)
    flow.reports("far", 1, 3)
    flow.leaves("far", 0)
    flow.put(1)
    assert flow.deaths() == []
    flow.comes("far", 1)
    assert flow.deaths() == [(1, 2)]
    assert flow.deaths() == []


def test_when_the_session_closes_all_are_lost_that_have_not_taken_the_end() -> None:
    flow = Flow()
    flow.ends("far", 0)
    flow.lose_all()
    assert flow.lost == {0}
    assert flow.credit() == DEPTH


def test_a_report_takes_no_credit_back() -> None:
    """A reader that was cut off reports less than it got credit for when it was back; a send raised then."""
    flow = Flow()
    flow.put(DEPTH)
    flow.reports("near", DEPTH, DEPTH)
    flow.leaves("far", 0)
    flow.comes("far", 0)
    assert flow.credit() == DEPTH
    assert flow.reports("far", 1, 1)
    assert flow.credit() == DEPTH


def test_all_is_taken_once_every_reader_says_so() -> None:
    flow = Flow()
    flow.put(2)
    flow.tokens += 1  # a watermark
    flow.reports("near", 0, 3)
    flow.reports("far", 2, 2)
    assert not flow.all_taken
    flow.reports("far", 2, 3)
    assert flow.all_taken, "what is consumed does not count"
    flow.put(1)
    assert not flow.all_taken
    flow.leaves("far", 0)
    flow.reports("near", 0, 4)
    assert flow.all_taken, "nothing is on its way to a reader that is away"


def test_a_reader_whose_edge_has_left_counts_no_more() -> None:
    flow = Flow()
    flow.put(DEPTH)
    flow.reports("near", DEPTH, DEPTH)
    flow.dismiss(1)
    assert flow.credit() == DEPTH
    assert flow.all_taken
    assert flow.reports("far", 1, DEPTH), "it may still speak"
    flow.leaves("far", 0)
    flow.comes("far", 1)
    flow.close()
    assert flow.deaths() == []
    assert flow.lost == frozenset()
    assert flow.refused == 0
    flow.ends("near", 0)
    assert flow.ended
