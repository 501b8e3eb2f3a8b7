"""What a message promises: a checked, sealed, immutable structure of arrays with a header."""

from __future__ import annotations

import ctypes
import dataclasses

import numpy as np
import pytest

from followspot.message_checks.sealing import seal
from followspot.messages import (
    MAX_TEXTS,
    UNSTAMPED,
    Array,
    Header,
    InvalidMessage,
    Message,
    at,
    column,
    identical,
    stamped,
)
from followspot.transport.codec import pack, unpack
from followspot.transport.ring.memory import Memory


class Points(Message):
    camera: str
    xy: Array = column("N", 2, unit="px")
    weight: Array = column("N")
    size: Array = column(2, dtype="i4", unit="px")


def points(n: int = 3) -> Points:
    return Points("cam0", np.arange(2.0 * n).reshape(n, 2), np.arange(float(n)), np.array([320, 240], "i4"))


def test_sealed_arrays_are_read_only_and_contiguous() -> None:
    message = points()
    object.__setattr__(message, "xy", np.zeros((2, 3)).T)
    sealed = seal(message)
    assert sealed.xy.flags.c_contiguous
    with pytest.raises(ValueError, match="read-only"):
        sealed.xy[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        sealed.camera = "cam1"  # type: ignore[misc]


@pytest.mark.parametrize(
    ("field", "value", "reason"),
    [
        ("xy", [[1.0, 2.0]], "xy is a list, not a numpy array"),
        ("xy", np.zeros((3, 2), "f4"), "xy has dtype float32, declared float64"),
        ("xy", np.zeros((3, 3)), r"xy has shape \(3, 3\), declared \('N', 2\)"),
        ("xy", np.zeros(3), r"xy has shape \(3,\)"),
        ("weight", np.zeros(4), r"weight has shape \(4,\), declared \('N',\) with {'N': 3}"),
        ("size", np.zeros(3, "i4"), r"size has shape \(3,\), declared \(2,\)"),
    ],
)
def test_what_breaks_the_contract_is_refused_with_the_reason(field: str, value: object, reason: str) -> None:
    message = points()
    object.__setattr__(message, field, value)
    with pytest.raises(InvalidMessage, match=reason):
        seal(message)


class Told(Message):
    number: int
    text: str
    names: tuple[str, ...]


@pytest.mark.parametrize(
    ("field", "value", "reason"),
    [
        ("number", "5", "number is a str, declared int"),
        ("number", None, "number is None, declared int"),
        ("text", 5, "text is an int, declared str"),
        ("names", ["a"], "names is a list, declared tuple[str, ...]"),
    ],
)
def test_types_of_a_wrong_field_are_named_as_declarations_write_them(
    field: str, value: object, reason: str
) -> None:
    told = Told(**({"number": 1, "text": "", "names": ()} | {field: value}))
    with pytest.raises(InvalidMessage) as refused:
        seal(told)
    assert str(refused.value) == reason


@pytest.mark.parametrize(
    ("told", "reason"),
    [
        (Told(1 << 63, "", ()), "number is no number of 64 bits"),
        (Told(-(1 << 63) - 1, "", ()), "number is no number of 64 bits"),
        (Told(10**5000, "", ()), "number is no number of 64 bits"),
        (Told(0, "\ud800", ()), "text is no Unicode text"),
        (Told(0, "", ("ä", "\udcff")), "names is no Unicode text"),
        (Told(0, "x" * MAX_TEXTS, ()), rf"the texts \(text, names\) have {MAX_TEXTS + 3} bytes, at most"),
        (Told(0, "ä" * (MAX_TEXTS // 2), ()), f"at most {MAX_TEXTS} allowed"),
        (Told(0, "", ("",) * (MAX_TEXTS // 3)), f"at most {MAX_TEXTS} allowed"),
    ],
)
def test_what_cannot_travel_is_refused_by_edges_within_a_process_too(told: Told, reason: str) -> None:
    with pytest.raises(InvalidMessage, match=reason):
        seal(told)


@pytest.mark.parametrize("number", [-(1 << 63), (1 << 63) - 1])
def test_numbers_of_64_bits_and_any_text_can_travel(number: int) -> None:
    assert seal(Told(number, "ä\0", ("😀", ""))).number == number


@pytest.mark.parametrize("text", ["x" * (MAX_TEXTS - 3), "😀" * (MAX_TEXTS // 4 - 1)])
def test_the_longest_texts_can_travel_between_processes(text: str) -> None:
    assert unpack(pack(seal(Told(0, text, ()))), Told).text == text  # type: ignore[union-attr]


def test_empty_message_has_no_rows_and_is_valid() -> None:
    empty = seal(Points.empty())
    assert (empty.xy.shape, empty.weight.shape, empty.size.shape, empty.camera) == ((0, 2), (0,), (2,), "")


def test_a_message_that_was_sent_before_is_copied_not_restamped() -> None:
    first = stamped(points(), Header("a", 1, 10))
    second = stamped(first, Header("b", 2, 20))
    assert (first.header.source, second.header.source) == ("a", "b")
    assert second.xy is first.xy
    assert identical(first, stamped(second, first.header))
    assert not identical(first, second)


def test_a_source_says_when_and_the_runtime_says_who() -> None:
    yielded = at(5, points(), seq=3)
    assert yielded.header == Header("", 3, 5)
    assert stamped(yielded, Header("camera", 3, 5)) is yielded
    assert points().header is UNSTAMPED


def test_where_keeps_corresponding_rows() -> None:
    kept = points().where(np.array([True, False, True]))
    assert kept.weight.tolist() == [0.0, 2.0]
    assert kept.xy.tolist() == [[0.0, 1.0], [4.0, 5.0]]
    assert kept.size.tolist() == [320, 240]
    assert seal(kept).camera == "cam0"


def test_a_field_that_cannot_travel_is_refused_at_once() -> None:
    with pytest.raises(TypeError, match=r"Broken\.names: a field is a column"):

        class Broken(Message):
            names: dict[str, int]


@pytest.mark.parametrize(
    ("declared", "reason"),
    [
        (column("N", dtype="O"), r"wrong: a column holds numbers or truth values, not dtype \|O"),
        (column("N", dtype="g"), r"not dtype <f16"),
        (column("N", dtype="M8[ns]"), r"not dtype <M8\[ns\]"),
        (column("N", refers="targets"), "holds indices, which are integers: give it a dtype such as i4"),
        (column(*range(1, 10)), "has 9 dimensions, at most 8"),
        (column("N", -3), r"has the shape \('N', -3\): sizes are names, or whole numbers from 0"),
        (column(2.5), "sizes are names"),  # type: ignore[arg-type]
    ],
)
def test_a_column_that_cannot_travel_is_refused_at_once(declared: object, reason: str) -> None:
    with pytest.raises(TypeError, match=reason):
        type("Broken", (Message,), {"__annotations__": {"wrong": Array}, "wrong": declared})


@pytest.mark.parametrize("name", ["header", "columns", "is_empty", "where", "as_table"])
def test_a_field_cannot_have_a_name_that_every_message_has(name: str) -> None:
    with pytest.raises(TypeError, match=rf"Broken\.{name}: a message has this name already"):
        type("Broken", (Message,), {"__annotations__": {name: int}})


def test_what_a_stage_writes_to_its_own_arrays_later_changes_no_sent_message() -> None:
    buffer = np.arange(10.0)
    part = seal(Points("cam0", buffer[:6].reshape(3, 2), buffer[6:9], np.array([320, 240], "i4")))
    buffer[:] = -1.0
    assert part.xy.tolist() == [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]
    assert part.weight.tolist() == [6.0, 7.0, 8.0]
    whole = seal(Points("cam0", np.zeros((10, 2)), buffer[:], np.array([320, 240], "i4")))
    assert whole.weight.base is buffer
    with pytest.raises(ValueError, match="read-only"):
        buffer[0] = 1.0


@pytest.mark.parametrize("buffer", [bytearray(48), (ctypes.c_double * 6)()], ids=["bytearray", "ctypes"])
def test_what_a_driver_writes_to_its_buffer_later_changes_no_sent_message(buffer: bytearray) -> None:
    memory = np.frombuffer(buffer)
    sent = seal(Points("cam0", memory.reshape(3, 2), np.frombuffer(buffer)[:3], np.zeros(2, "i4")))
    memory[:] = 1.0
    assert not sent.xy.any()
    assert not sent.weight.any()
    fixed = np.frombuffer(bytes(48)).reshape(3, 2)
    assert seal(Points("cam0", fixed, np.zeros(3), np.zeros(2, "i4"))).xy is fixed, "bytes never change"


def test_a_stage_may_fill_the_rest_of_a_loan_after_sending_a_part() -> None:
    loan = np.ndarray((4, 2), "f8", Memory.create("loan", 64).bytes)
    part = seal(Points("cam0", loan[:3], np.zeros(3), np.zeros(2, "i4")))
    loan[:] = 1.0
    assert not part.xy.any()
    whole = seal(Points("cam0", loan[:], np.zeros(4), np.zeros(2, "i4")))
    assert whole.xy.base is loan
    with pytest.raises(ValueError, match="read-only"):
        loan[0] = 2.0


class Mask(Message):
    inside: Array = column("H", "W", dtype="?")


def test_truth_values_that_view_other_numbers_travel_as_truth_values() -> None:
    mask = np.array([[0, 255], [4, 1]], "u1")
    sent = stamped(seal(Mask(mask.view(bool))), Header("a", 0, 0))
    assert sent.inside.tobytes() == bytes([0, 1, 1, 1])
    received = unpack(pack(sent), Mask)
    assert isinstance(received, Mask)
    assert identical(received, sent)
    assert mask.tolist() == [[0, 255], [4, 1]]
