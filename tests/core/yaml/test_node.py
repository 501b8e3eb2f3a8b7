"""YAML 1.2 with places, and limits that no file passes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from followspot import files
from followspot.errors import InputError, Mistake, Place
from followspot.yaml.node import MAX_DEPTH, Node, child, dump, node_of, plain
from followspot.yaml.reader import parse, read
from followspot.yaml.scalars import LARGEST_INT


def value(text: str) -> Any:
    return plain(parse(text, "test.yaml"))


def mistakes(text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        parse(text, "test.yaml")
    return [f"{m.place}: {m.text}" for m in caught.value.mistakes]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("true", True),
        ("False", False),
        ("on", "on"),
        ("yes", "yes"),
        ("n", "n"),
        ("~", None),
        ("null", None),
        ("", None),
        ("12", 12),
        ("-12", -12),
        ("012", 12),
        ("0o14", 12),
        ("0x1F", 31),
        ("1_000", "1_000"),
        ("1:30", "1:30"),
        ("2024-01-01", "2024-01-01"),
        ("1.5", 1.5),
        ("1e-05", 1e-05),
        (".5", 0.5),
        ("3.", 3.0),
        ("-.inf", -math.inf),
        ('"12"', "12"),
        ("'true'", "true"),
        ("!!str 12", "12"),
        ("|\n  a\n  b\n", "a\nb\n"),
        ("012.5.1", "012.5.1"),
    ],
)
def test_scalars_follow_yaml_1_2(text: str, expected: Any) -> None:
    found = value(f"a: {text}")["a"]
    assert found == expected
    assert type(found) is type(expected)


def test_keys_are_text_whatever_they_look_like() -> None:
    assert value("{0: a, true: b, null: c, 1.0: d}") == {"0": "a", "True": "b", "None": "c", "1.0": "d"}


def test_nodes_know_the_places_of_keys_and_values() -> None:
    root = parse("a: 1\nb:\n  - x\n  - {cé: 'dd'}\n", "test.yaml")
    entry = child(root, "b")
    assert entry is not None
    assert entry.key == Place("test.yaml", 2, 1)
    assert isinstance(entry.value, tuple)
    inner = child(entry.value[1], "cé")
    assert inner is not None
    assert (inner.key, inner.place) == (Place("test.yaml", 4, 6, 2), Place("test.yaml", 4, 10, 4))


def test_merge_keys_fill_what_the_mapping_does_not_say() -> None:
    text = "base: &b {x: 1, y: 2}\nmore: &m {y: 3, z: 4}\nall: {<<: [*b, *m], x: 5}"
    assert value(text)["all"] == {"x": 5, "y": 2, "z": 4}


def test_every_duplicate_key_is_reported_at_once() -> None:
    assert mistakes("a: 1\nb: {c: 1, c: 2}\na: 2\n") == [
        'test.yaml:2:11: the key "c" stands here twice',
        'test.yaml:3:1: the key "a" stands here twice',
    ]


def test_a_key_beside_a_merge_is_no_duplicate() -> None:
    assert value("b: &b {x: 1}\na: {<<: *b, x: 2}")["a"] == {"x": 2}


def test_a_syntax_error_behind_the_end_is_placed_at_the_end() -> None:
    assert mistakes("a: [1, 2") == ["test.yaml:1:9: not valid YAML: did not find expected ',' or ']'"]


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("a:\n\tb: c", 2, 1),
        ("a:\n  b: c\n  \td: e", 3, 3),
        ("a:\n  b: c\n\td: e", 3, 1),
        ("a: |\n\tb", 2, 1),
    ],
)
def test_a_tab_that_indents_is_called_a_tab(text: str, line: int, column: int) -> None:
    where = f"test.yaml:{line}:{column}"
    assert mistakes(text) == [f"{where}: a tab stands here, and YAML indents by spaces"]


def test_an_alias_cannot_contain_itself() -> None:
    assert mistakes("a: &x [*x]") == ['test.yaml:1:8: no anchor "&x" stands before this alias']


def test_a_short_file_that_unfolds_into_a_long_one_is_refused() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 9)]
    assert "more than 100000 values" in mistakes("\n".join(lines))[0]


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
def test_deep_nesting_is_a_mistake_and_no_crash(opening: str) -> None:
    assert mistakes(opening * 5000)


def test_depth_is_counted_through_aliases() -> None:
    half = MAX_DEPTH // 2 + 1
    text = f"a: &a {'[' * half}{']' * half}\nb: {'[' * half}*a{']' * half}\n"
    assert f"nested more than {MAX_DEPTH} deep" in mistakes(text)[0]


def test_an_integer_of_many_digits_is_a_mistake() -> None:
    assert mistakes("a: " + "9" * 5000) == ["test.yaml:1:4: this number has too many digits"]


def test_large_missing_and_binary_files_are_mistakes(tmp_path: Path) -> None:
    large = tmp_path / "large.yaml"
    large.write_bytes(b"#" * (files.DOCUMENT + 1))
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"a: 1\nb: \xff\xfe\n")
    for path, said in (
        (large, "larger than"),
        (binary, "2:4: this byte is not UTF-8"),
        (tmp_path, "cannot read"),
    ):
        with pytest.raises(InputError, match=said):
            read(path)
    with pytest.raises(InputError, match="cannot read"):
        read(tmp_path / "none.yaml")


def test_a_byte_order_mark_shifts_nothing(tmp_path: Path) -> None:
    path = tmp_path / "bom.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\n")
    assert child(read(path), "a") == Node(1, Place(str(path), 1, 4), Place(str(path), 1, 1))


INTEGERS = st.integers(-LARGEST_INT - 1, LARGEST_INT)
JSON = st.recursive(
    st.none() | st.booleans() | INTEGERS | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


@given(JSON)
@settings(suppress_health_check=[HealthCheck.too_slow])  # trees take long to make on a busy machine
def test_plain_is_the_inverse_of_node_of(data: Any) -> None:
    assert plain(node_of(data, Place("data", 1, 1))) == data


def test_text_is_written_as_it_is() -> None:
    assert dump({"graph": "Bühne", "seen": ["舞台", "🎭"]}) == "graph: Bühne\nseen: [舞台, 🎭]\n"


@given(st.text() | st.text(alphabet="a: \x85\u2028\u2029\ufeff\n\t'\"\u00e9\x9b"))
@example("\x85")
def test_any_text_that_is_written_is_read_again(text: str) -> None:
    assert plain(parse(dump({"a": [text], f"b{text}": text}), "x")) == {"a": [text], f"b{text}": text}


def mistakes_or_none(read_it: Callable[[], Node]) -> Sequence[Mistake]:
    """The mistakes; anything else that is raised fails the test."""
    try:
        read_it()
    except InputError as error:
        return error.mistakes
    return ()


@settings(max_examples=120, deadline=None)
@given(st.text(max_size=80) | st.text(alphabet="ab:{}[]&*!<-?|>'\"#%@, \n\t0.", max_size=80))
@example("a: \ud800")
@example("a: \x85b: 1")
def test_any_text_is_read_or_is_a_mistake_with_a_place(text: str) -> None:
    for mistake in mistakes_or_none(lambda: parse(text, "fuzz.yaml")):
        assert mistake.place is not None
        assert mistake.place.line >= 1
        assert mistake.place.column >= 1


@settings(max_examples=100, deadline=None)
@given(data=st.binary(max_size=60))
def test_any_file_is_read_or_is_a_mistake(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "fuzz.yaml"
    path.write_bytes(data)
    assert all(mistake.text for mistake in mistakes_or_none(lambda: read(path)))
