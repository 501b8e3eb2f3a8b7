"""Rows of a CSV file from another program: limited in size, checked, every mistake with its line."""

from __future__ import annotations

import csv
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import copy_context
from dataclasses import dataclass
from decimal import Decimal, DecimalException
from pathlib import Path
from types import MappingProxyType

from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.files import open_regular, open_text
from followspot.messages import MAX_TIME

MOST_ROWS = 5_000_000
FIRST_ROWS = 100
"""Rows that are read before a run."""
FIRST_LINE = 2
"""Number of the line that has the first row."""
LONGEST_NAME = 100
LARGEST = 2**31 - 1
DECIMALS = {"s": 9, "ms": 6, "us": 3, "ns": 0}
"""Digits after the point of a time in ns, by its unit."""
SEPARATORS = {";": "semicolons", "\t": "tabs"}
"""Separators that spreadsheets write in place of commas."""
FLAGS = {"0": False, "1": True, "false": False, "true": True}


@dataclass(frozen=True)
class Row:
    """One line of a CSV file, and the position of each column that was asked for and is there."""

    file: str
    line: int
    cells: Sequence[str]
    columns: Mapping[str, int]

    def cell(self, column: str) -> str:
        """The text of the cell."""
        return self.cells[self.columns[column]].strip()

    def text(self, column: str) -> str:
        """A short name. Raises InputError."""
        cell = self.cell(column)
        if not 0 < len(cell) <= LONGEST_NAME:
            raise self.mistake(column, f"a name of 1 to {LONGEST_NAME} characters")
        return cell

    def number(self, column: str) -> float:
        """A finite number. Raises InputError."""
        try:
            value = float(_plain(self.cell(column)))
        except ValueError:
            raise self.mistake(column, "a number") from None
        if not math.isfinite(value):
            raise self.mistake(column, "a finite number")
        return value

    def integer(self, column: str) -> int:
        """A whole number from 0. Raises InputError."""
        value = self.number(column)
        if value % 1 or not 0 <= value <= LARGEST:
            raise self.mistake(column, f"a whole number from 0 to {LARGEST}")
        return int(value)

    def nanoseconds(self, column: str, unit: str) -> int:
        """A time in ns without the error of binary fractions. unit: of `DECIMALS`. Raises InputError."""
        # in a copy: decimal adds its settings to the context, which would slow down later calls of numpy
        time = copy_context().run(_nanoseconds, self.cell(column), unit)
        if time is None:
            raise self.mistake(column, f"a time in {unit}")
        return time

    def numbers(self, *columns: str) -> list[float]:
        """Finite numbers. Raises InputError."""
        return [self.number(column) for column in columns]

    def flag(self, column: str) -> bool:
        """0 or 1. Raises InputError."""
        value = FLAGS.get(self.cell(column).lower())
        if value is None:
            raise self.mistake(column, "0 or 1")
        return value

    def has(self, column: str) -> bool:
        """True if the file has this column."""
        return column in self.columns

    def known(self, column: str, names: Collection[str], noun: str) -> str:
        """A name that is among these. Raises InputError with the most similar one."""
        cell = self.cell(column)
        if cell not in names:
            wrong = self.mistake(column, "").mistakes[0]
            raise InputError([Mistake(wrong.place, wrong.text, did_you_mean(cell, names, noun))])
        return cell

    def choice(self, column: str, words: Sequence[str]) -> int:
        """Index of the word among the allowed ones. Raises InputError."""
        cell = self.cell(column)
        if cell not in words:
            raise self.mistake(column, f"one of {', '.join(words)}")
        return words.index(cell)

    def mistake(self, column: str, wanted: str) -> InputError:
        """The mistake with the text of the cell and the wanted one."""
        index = self.columns[column]
        before = sum(len(cell) + 1 for cell in self.cells[:index])
        place = Place(self.file, self.line, before + 1, max(1, len(self.cells[index])))
        text = f'"{self.cells[index][:40]}" in column {column}'
        return InputError([Mistake(place, text, f"needs {wanted}")])


def read_rows(
    path: Path,
    columns: Sequence[str],
    optional: Sequence[str] = (),
    named: Mapping[str, str] = MappingProxyType({}),
) -> Iterator[Row]:
    """Rows of a CSV file whose first line names at least these columns.

    optional: columns that are read if they are there; named: the name in the file of each column that has
    another one there. Raises InputError if the file cannot be read, lacks a column or has more than
    `MOST_ROWS` rows.
    """
    with _lines(path) as lines:
        yield from _rows(str(path), lines, columns, optional, named)


def header_of(path: Path) -> tuple[str, ...]:
    """The names in the first line of a CSV file. Raises InputError."""
    with _lines(path) as lines:
        return tuple(_head(str(path), lines))


def _nanoseconds(text: str, unit: str) -> int | None:
    """A time in ns; None if the text is none."""
    try:
        value = Decimal(_plain(text)).scaleb(DECIMALS[unit])
        return int(value.to_integral_value()) if abs(value) < MAX_TIME // 2 else None
    except (DecimalException, ValueError):
        return None


def _plain(number: str) -> str:
    """The text of a number, as it is. Raises ValueError if only Python takes it for one.

    Python reads 1_000 and the digits of other scripts; in a CSV file they are damage.
    """
    if "_" in number or not number.isascii():
        raise ValueError(number)
    return number


@contextmanager
def _lines(path: Path) -> Iterator[Iterator[list[str]]]:
    reader = csv.reader(())
    try:
        with open_text(path) as file:
            reader = csv.reader(file)
            yield reader
    except OSError as error:
        raise InputError([Mistake(None, f"{path} cannot be read: {error.strerror}")]) from None
    except UnicodeDecodeError:
        place = Place(str(path), _undecodable(path), 1)
        raise InputError([Mistake(place, "this is not UTF-8", "save the file as CSV in UTF-8")]) from None
    except csv.Error as error:
        place = Place(str(path), reader.line_num, 1)
        raise InputError([Mistake(place, f"this is not CSV: {error}")]) from None


def _undecodable(path: Path) -> int:
    """Number of the first line that is no UTF-8. Raises OSError."""
    with open_regular(path) as file:
        for line, content in enumerate(file, 1):
            try:
                content.decode()
            except UnicodeDecodeError:
                return line
    return 1


def _head(file: str, lines: Iterator[list[str]]) -> list[str]:
    """The names in the first line. Raises InputError if something else than commas separates them."""
    head = [cell.strip() for cell in next(lines, [])]
    for separator, name in SEPARATORS.items():
        if len(head) == 1 and separator in head[0]:
            text = f"columns are separated by {name}"
            raise InputError([Mistake(Place(file, 1, 1), text, "separate them by commas")])
    return head


def _rows(
    file: str,
    lines: Iterator[list[str]],
    columns: Sequence[str],
    optional: Sequence[str],
    named: Mapping[str, str],
) -> Iterator[Row]:
    head = _head(file, lines)
    index = _positions(file, head, columns, optional, named)
    needed = max(index.values(), default=-1) + 1
    for line, cells in enumerate(lines, FIRST_LINE):
        if not cells:
            continue
        if any("\n" in cell for cell in cells):
            text = "a quote that begins in this line goes on in the next"
            raise InputError([Mistake(Place(file, line, 1), text, "close the quote, or remove it")])
        if len(cells) < needed:
            text = f"{len(cells)} columns, {needed} needed"
            raise InputError([Mistake(Place(file, line, 1), text, "the line is not complete")])
        if any(cell.strip() for cell in cells[len(head) :]):
            text = f"{len(cells)} columns, but the first line names {len(head)}"
            remedy = "write numbers with a decimal point, and texts with a comma in quotes"
            raise InputError([Mistake(Place(file, line, 1), text, remedy)])
        if line > MOST_ROWS:
            text = f"more than {MOST_ROWS} rows"
            raise InputError([Mistake(Place(file, line, 1), text, "split the file")])
        yield Row(file, line, cells, index)


def _positions(
    file: str, head: Sequence[str], columns: Sequence[str], optional: Sequence[str], named: Mapping[str, str]
) -> dict[str, int]:
    """Position of each column that is there, among the names in the first line. Raises InputError."""
    wanted = {name: named.get(name, name) for name in (*columns, *optional)}
    absent = [wanted[name] for name in columns if wanted[name] not in head]
    absent += [word for name, word in named.items() if name in optional and word not in head]
    if absent:
        text = f"missing columns: {', '.join(absent)}"
        raise InputError([Mistake(Place(file, 1, 1), text, did_you_mean(absent[0], head, "columns"))])
    shared = [word for word in wanted.values() if [*wanted.values()].count(word) > 1 and word in head]
    if shared:
        text = f"column {shared[0]} would be read as several"
        raise InputError([Mistake(Place(file, 1, 1), text, "columns: name each column of the file once")])
    twice = [word for word in wanted.values() if head.count(word) > 1]
    if twice:
        text = f"the first line names column {twice[0]} twice"
        raise InputError([Mistake(Place(file, 1, 1), text, "rename one")])
    return {name: head.index(word) for name, word in wanted.items() if word in head}
