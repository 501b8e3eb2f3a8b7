"""Rows of somebody else's CSV file: what is taken, what is refused, and where the mistake is."""

from __future__ import annotations

from contextvars import Context
from pathlib import Path

import pytest

from followspot import InputError
from followspot.csv_rows import Row, header_of, read_rows


def only_row(path: Path, text: str, columns: str = "time, hidden,object") -> Row:
    path.write_text(f"{columns}\n{text}\n")
    (row,) = read_rows(path, [name.strip() for name in columns.split(",")])
    return row


@pytest.mark.parametrize(
    ("word", "value"), [("0", False), ("1", True), ("false", False), ("true", True), (" True", True)]
)
def test_flags_are_digits_or_words(tmp_path: Path, word: str, value: bool) -> None:
    assert only_row(tmp_path / "truth.csv", f"0.5,{word},a").flag("hidden") is value


@pytest.mark.parametrize("word", ["2", "yes", ""])
def test_another_flag_is_refused_by_line_and_column(tmp_path: Path, word: str) -> None:
    row = only_row(tmp_path / "truth.csv", f"0.5,{word},a")
    with pytest.raises(InputError, match=rf'(?s)truth\.csv:2:5: "{word}" in column hidden.*needs 0 or 1'):
        row.flag("hidden")


def test_whole_numbers_are_those_that_an_int32_holds(tmp_path: Path) -> None:
    row = only_row(tmp_path / "poses.csv", "0,2147483647,2147483648,-1,1.5", "zero,most,more,less,part")
    assert (row.integer("zero"), row.integer("most")) == (0, 2**31 - 1)
    for column in ("more", "less", "part"):
        with pytest.raises(InputError, match=f"(?s)in column {column}.*a whole number from 0 to 2147483647"):
            row.integer(column)


def test_names_have_one_to_a_hundred_characters(tmp_path: Path) -> None:
    row = only_row(tmp_path / "tracks.csv", f" red ,{'a' * 100},{'a' * 101}, ,1", "name,long,longer,none,x")
    assert (row.text("name"), row.text("long")) == ("red", "a" * 100)
    for column in ("longer", "none"):
        with pytest.raises(InputError, match=f"(?s)in column {column}.*a name of 1 to 100 characters"):
            row.text(column)


@pytest.mark.parametrize("text", ["9e999999", "-9e999999", "1e99", "nan", "inf", "", "x"])
def test_a_time_that_no_clock_shows_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match=r"(?s)truth\.csv:2:1.*a time in s"):
        only_row(tmp_path / "truth.csv", f"{text},0,a").nanoseconds("time", "s")


@pytest.mark.parametrize("text", ["1_000", "\uff11\uff12", "\u0661.5"])
def test_digits_of_other_scripts_and_underscores_make_no_number(tmp_path: Path, text: str) -> None:
    row = only_row(tmp_path / "tracks.csv", f"{text},{text},a")
    with pytest.raises(InputError, match=r"(?s)tracks\.csv:2:1.*needs a number"):
        row.number("time")
    with pytest.raises(InputError, match=r"(?s)tracks\.csv:2:1.*needs a number"):
        row.integer("time")
    with pytest.raises(InputError, match=r"(?s)tracks\.csv:2:1.*needs a time in s"):
        row.nanoseconds("time", "s")


def test_times_are_exact_to_the_nanosecond(tmp_path: Path) -> None:
    row = only_row(tmp_path / "truth.csv", "1764360000.123456789,0,a")
    here = Context()
    assert here.run(row.nanoseconds, "time", "s") == 1764360000123456789
    assert not len(here), "a context variable would make each later call of numpy slower"


def test_a_file_with_none_of_the_optional_columns_has_rows(tmp_path: Path) -> None:
    path = tmp_path / "tracks.csv"
    path.write_text("x,y\n1,2\n")
    assert [row.has("z") for row in read_rows(path, [], ["z"])] == [False]


@pytest.mark.parametrize(("text", "name"), [("x;y\n1;2\n", "semicolons"), ("x\ty\n1\t2\n", "tabs")])
def test_other_separators_than_commas_are_named(tmp_path: Path, text: str, name: str) -> None:
    path = tmp_path / "tracks.csv"
    path.write_text(text)
    for read in (header_of, lambda file: next(read_rows(file, ["x", "y"]))):
        with pytest.raises(InputError, match=f"(?s)tracks.csv:1:1: columns are separated by {name}.*commas"):
            read(path)


def test_a_quote_that_is_not_closed_is_told_by_its_line(tmp_path: Path) -> None:
    path = tmp_path / "readings.csv"
    path.write_text('x,note\n1,fine\n2,"open\n3,more\n4,more\n')
    rows = read_rows(path, ["x"])
    assert next(rows).number("x") == 1
    with pytest.raises(InputError, match=r"(?s)readings\.csv:3:1: a quote .* close the quote"):
        next(rows)


def test_empty_lines_are_passed_over_and_short_ones_refused(tmp_path: Path) -> None:
    path = tmp_path / "tracks.csv"
    path.write_text("x, y,more\n1,2,3\n\n4,5\n6\n")
    rows = read_rows(path, ["y", "x"])
    assert next(rows).numbers("x", "y") == [1, 2]
    row = next(rows)
    assert (row.line, row.numbers("x", "y")) == (4, [4, 5])
    with pytest.raises(InputError, match=r"tracks\.csv:5:1: 1 columns, 2 needed"):
        next(rows)
    assert header_of(path) == ("x", "y", "more")


def test_rows_with_more_columns_than_the_first_line_names_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x,y\n1,2,\n1,5,2,5\n")
    rows = read_rows(path, ["x", "y"])
    assert next(rows).numbers("x", "y") == [1, 2]  # an empty cell at the end is no value
    with pytest.raises(InputError, match=r"points\.csv:3:1: 4 columns, but the first line names 2"):
        next(rows)
    path.write_text("x,y,x\n1,2,3\n")
    with pytest.raises(InputError, match=r"points\.csv:1:1: the first line names column x twice"):
        next(read_rows(path, ["x", "y"]))


def test_every_column_that_is_missing_is_named(tmp_path: Path) -> None:
    (tmp_path / "tracks.csv").write_text("time,x\n")
    with pytest.raises(InputError, match=r"tracks\.csv:1:1: missing columns: object, y"):
        list(read_rows(tmp_path / "tracks.csv", ["time", "object", "x", "y"]))


@pytest.mark.parametrize(
    ("damaged", "line", "what"),
    [
        (b"time\n" + b"0\n" * 9000 + "\u00e9\n".encode("latin-1"), 9002, "this is not UTF-8"),
        ("time\n0\n".encode("utf-16"), 1, "this is not UTF-8"),
        (b"time\n0\n" + b"1" * 200_000 + b"\n", 3, "this is not CSV: field larger than field limit"),
    ],
)
def test_what_is_no_text_or_no_table_is_told_by_its_line(
    tmp_path: Path, damaged: bytes, line: int, what: str
) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(damaged)
    with pytest.raises(InputError, match=rf"a\.csv:{line}:1: {what}"):
        list(read_rows(path, ["time"]))
