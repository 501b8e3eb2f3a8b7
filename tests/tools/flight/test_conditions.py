"""Conditions are parsed by a grammar of their own, checked before a run, and mark when they begin to hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot import Array, Message, column
from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.library.handle import RunStatus
from followspot.message_checks.sealing import seal
from followspot.testing import tiny_room
from followspot.tracking import STATES, Tracks
from followspot.wire import pack
from followspot_record.flight.condition import Condition, split_condition
from followspot_record.flight.figures import LEDGER
from followspot_record.flight.watch import ConditionWatch

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
NOTHING = dict.fromkeys(LEDGER, 0)
ROOM = tiny_room()


class Weather(Message):
    """A message of a stranger."""

    station: str
    windy: bool
    celsius: float
    gusts: Array = column("N", unit="m/s")


def tracks(*states: str, height: float = 1.0) -> Tracks:
    rows = len(states)
    xyz = np.tile([0.5, -0.25, height], (rows, 1))
    known = np.array([STATES.index(state) for state in states], "u1")
    return seal(Tracks(np.zeros(rows, "i4"), known, xyz, np.zeros((rows, 3)), np.full((rows, 3), 0.01)))


def condition(text: str, kind: type[Message] = Tracks) -> Condition:
    _, source = split_condition(f"track.tracks: {text}")
    return Condition(source, kind, ROOM)


def holds(text: str, message: Message, **losses: int) -> bool:
    return condition(text, type(message)).holds(message, NOTHING | losses)


@pytest.mark.parametrize(
    ("text", "result"),
    [
        ("state == missing", True),
        ("state == lost", False),
        ("lost == state", False),
        ("state != tracked", True),
        ("all(state == tracked)", False),
        ("count(state == tracked) < 3", True),
        ("count(state == tracked) == 2", True),
        ("rows == 3", True),
        ("z > 0.9 and z < 1.1", True),
        ("z > 1.1 or object == red", True),
        ("not (z > 1.1)", True),
        ("y < -0.2", True),
        ("abs(y) < 0.2", False),
        ("max(sx) * 1000 > 9.5", True),
        ("2 + 3 * 4 == 14", True),
        ("(2 + 3) * 4 == 14", False),
        ("2 - 1 - 1 == 0", True),
        ("-x < -.4", True),
        ("mean(z) / 0 > 1e9", True),
        ("dropped > 0", False),
        ("any(z < 2) and late >= 0", True),
    ],
)
def test_a_condition_holds_of_a_message(text: str, result: bool) -> None:
    assert holds(text, tracks("tracked", "missing", "tracked")) is result


def test_nothing_holds_of_rows_that_are_not_there() -> None:
    for text in ("z < 100", "z > 100", "state == lost", "max(z) > 0", "min(z) < 0"):
        assert not holds(text, tracks())
    assert holds("rows == 0", tracks())
    assert holds("count(z > 0) == 0", tracks())


def test_what_is_not_known_is_neither_more_nor_less() -> None:
    assert not holds("z < 5", tracks("tracked", height=np.nan))
    assert not holds("z >= 5", tracks("tracked", height=np.nan))


def test_single_values_and_texts_of_a_strangers_message() -> None:
    weather = seal(Weather("north", True, 30.5, np.array([3.0, 12.0])))
    assert holds("windy and celsius > 30 and station == north", weather)
    assert holds("station != 'south pole'", weather)
    assert holds("gusts > 10", weather)
    assert not holds("all(gusts > 10)", weather)


class Alarm(Message):
    """A single number, and a field with the name of a column that every table has."""

    level: Array = column()
    time: float


def test_a_condition_speaks_of_single_numbers_and_of_fields_by_the_names_of_tables() -> None:
    alarm = seal(Alarm(np.array(3.0), 20.0))
    assert holds("level > 2 and message_time > 10 and rows == 1", alarm)
    assert not holds("level > 4", alarm)


class Small(Message):
    """Numbers of few bits."""

    level: Array = column("N", dtype="u1")


@pytest.mark.parametrize(
    "text", ["-level < 0", "level - 4 - level < 0", "level + level > 255", "level * level > 255"]
)
def test_numbers_of_few_bits_do_not_wrap_around(text: str) -> None:
    assert holds(text, seal(Small(np.array([200], "u1"))))


def test_a_condition_over_the_ledger_speaks_of_what_was_lost_meanwhile() -> None:
    found = condition("drops > 0 or late > 2")
    assert not found.in_messages
    assert not found.holds(None, NOTHING)
    assert found.holds(None, NOTHING | {"dropped": 1})
    assert not found.holds(None, NOTHING | {"late": 2})
    assert condition("late > 0 and z > 0").in_messages


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("stat == lost", "stat", 'did you mean "state"'),
        ("state == lots", "lots", 'did you mean "lost"'),
        ("object == blue", "blue", "names: red"),
        ("state > lost", ">", "write == or !="),
        ("state", "state", "a comparison belongs here, and this is a name"),
        ("z", "z", "for example with > 0"),
        ("z > 1 and 2", "2", "a comparison belongs here"),
        ("z = 1", "=", "compare with =="),
        ("cnt(z > 1) > 2", "cnt", 'did you mean "count"'),
        ("count(z) > 2", "z", "a comparison belongs here"),
        ("z > ", "", "the expression ends"),
        ("(z > 1", "", "a bracket is not closed"),
        ("z > 1 z", "z", "does not belong here"),
        ("__import__('os')", "__import__", "there is no function"),
        ("z.real > 1", ".", "means nothing here"),
        ("1 < z < 2", "<", "does not belong here"),
        ("", "", "the expression ends"),
        ("z > 1" + " and z > 1" * 900, "z", "more than 400 pieces"),
        ("1" + "+1" * 4000 + " > 0", "1", "more than 400 pieces"),
        ("(" * 60 + "z > 1" + ")" * 60, "", "nested too deeply"),
    ],
)
def test_a_mistake_is_told_with_its_place_and_remedy(text: str, place: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        condition(text)
    (mistake,) = error.value.mistakes
    assert message in str(mistake)
    assert mistake.place is not None
    start = mistake.place.column - 1
    assert f"track.tracks: {text}"[start:].startswith(place)
    assert len(text) > 2000 or f"track.tracks: {text[:20]}" in str(mistake), "the line is quoted"


@given(st.text(alphabet="zx01.<>=!()+-*/ '\"andortcu_[]{}:,", max_size=30))
def test_any_text_is_a_condition_or_a_mistake(text: str) -> None:
    try:
        found = condition(text)
    except InputError:
        return
    assert found.holds(tracks("tracked"), NOTHING) in (True, False)


def watch(*texts: str) -> tuple[ConditionWatch, list[str]]:
    marks: list[str] = []
    plan = compile_graph(GRAPH)
    return ConditionWatch(texts, plan, {"track.tracks": Tracks}, marks.append), marks


def test_a_mark_is_made_when_a_condition_begins_to_hold_and_not_while_it_does() -> None:
    text = "track: count(state == tracked) < 2"
    watched, marks = watch(text)
    for states in (("tracked", "tracked"), ("tracked",), (), ("tracked", "tracked"), ("missing",)):
        watched.take("track.tracks", pack(tracks(*states)))
    assert marks == [text, text]


def test_what_the_ledger_lost_before_the_first_look_marks_nothing() -> None:
    watched, marks = watch("track.tracks: late > 0")
    plan = compile_graph(GRAPH)
    (number,) = [n for n, edge in plan.numbered() if f"{edge.from_stage}.{edge.from_port}" == "track.tracks"]
    for late in (3, 3, 4, 6, 6, 7):
        counts: Any = [0] * (16 * len(plan.edges))
        counts[16 * number + 2] = late
        watched.check(RunStatus((), tuple(counts), 0, None), plan)
    assert len(marks) == 2


def test_every_wrong_condition_is_told_at_once() -> None:
    with pytest.raises(InputError) as error:
        watch("track: stat == lost", "nowhere: rows > 0", "no port")
    told = str(error.value)
    assert 'did you mean "state"' in told
    assert 'there is no port "nowhere"' in told
    assert "names no port" in told
