"""The last seconds of each port are held, in no more memory than allowed."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from followspot_record.flight.kept_messages import KeptMessages
from followspot_record.flight.moment_span import MomentSpan

S = 1_000_000_000


def times(held: KeptMessages, port: str) -> list[int]:
    return [message.time for message in held.after({}) if message.port == port]


def test_messages_older_than_the_period_leave() -> None:
    held = KeptMessages(2.0, 1000)
    for second in range(6):
        held.put("a", second * S, 0, b"x")
    held.put("b", 0, 0, b"y")
    assert times(held, "a") == [3 * S, 4 * S, 5 * S]
    assert times(held, "b") == [0], "a port goes by its own times"
    assert (held.bytes, held.held()) == (4, 0.0)


def test_of_too_much_the_largest_port_loses_its_oldest() -> None:
    held = KeptMessages(100.0, 50)
    for second in range(10):
        held.put("pictures", second * S, 0, bytes(20))
        held.put("tracks", second * S, 0, b"x")
    assert held.bytes <= 50
    assert times(held, "tracks") == [second * S for second in range(10)]
    assert times(held, "pictures") == [8 * S, 9 * S]
    assert held.held() == 1.0


def test_one_message_larger_than_the_memory_stays_alone() -> None:
    held = KeptMessages(100.0, 50)
    for second in range(3):
        held.put("pictures", second * S, 0, bytes(80))
    assert times(held, "pictures") == [2 * S]


def test_a_recording_that_begins_anew_does_not_freeze_what_is_held() -> None:
    held = KeptMessages(2.0, 1000)
    for second in (50, 51, 0, 1):
        held.put("a", second * S, 0, b"x")
    assert times(held, "a") == [0, S]


@given(st.lists(st.tuples(st.sampled_from("abc"), st.integers(0, 30), st.integers(0, 40)), max_size=60))
def test_memory_is_bounded_whatever_comes(sent: list[tuple[str, int, int]]) -> None:
    held = KeptMessages(5.0, 60)
    for port, second, size in sent:
        held.put(port, second * S, 0, bytes(size))
        left = list(held.after({}))
        assert held.bytes == sum(len(message.packed) for message in left)
        assert held.bytes <= 60 or len(left) == len(held.ports)
        assert [message.number for message in left] == sorted(message.number for message in left)


def test_a_moment_has_each_message_once_up_to_its_end() -> None:
    held, span = KeptMessages(10.0, 1000), MomentSpan()
    for second in range(3):
        held.put("a", second * S, 0, b"x")
    got = [message.time for message in span.extend(held, 2.0, now=100.0)]
    for second in (3, 4, 5):
        message = held.put("a", second * S, 0, b"x")
        got += [message.time] if span.takes(message) else []
    assert got == [second * S for second in range(5)]
    assert span.over(held, now=101.0)
    got += [message.time for message in span.extend(held, 1.0, now=101.0)]
    assert got == [second * S for second in range(6)], "a second mark goes on where the first ended"


@given(st.lists(st.tuples(st.sampled_from("abc"), st.booleans()), max_size=40))
def test_every_port_goes_on_where_it_was_left(sent: list[tuple[str, bool]]) -> None:
    """Ports send at different times, and marks come between any two messages."""
    held, span = KeptMessages(1000.0, 1000), MomentSpan()
    got: list[int] = []
    for second, (port, marked) in enumerate(sent):
        message = held.put(port, second * S, 0, b"x")
        got += [message.number] if span.takes(message) else []
        if marked:
            got += [found.number for found in span.extend(held, 2.0, now=float(second))]
    got += [found.number for found in span.extend(held, 0.0, now=0.0)]
    assert sorted(got) == list(range(1, len(sent) + 1)), "each message once, and none is left out"


def test_a_moment_waits_for_a_port_that_is_behind_but_not_for_ever() -> None:
    held, span = KeptMessages(10.0, 1000), MomentSpan()
    held.put("a", 0, 0, b"x")
    held.put("silent", 0, 0, b"x")
    list(span.extend(held, 1.0, now=100.0))
    assert span.takes(held.put("a", S, 0, b"x"))
    assert not span.takes(held.put("a", 2 * S, 0, b"x"))
    assert not span.over(held, now=102.9)
    assert span.over(held, now=103.0)
