"""Mistakes in the user's input, with place, line and remedy."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from followspot.files import DOCUMENT, read_text

MOST_SHOWN = 50
"""Most mistakes that are shown; the rest is counted."""
MOST_COMPARED = 1000
"""Most known words that an unknown one is compared with."""
_LONGEST_WORD = 100
_LONGEST_TEXT = 600
_LONGEST_LINE = 160


class FollowspotError(Exception):
    """Base of every error that the user can correct; commands show its text without a traceback."""


@dataclass(frozen=True)
class Place:
    """A position in a file or on the command line; line and column count from 1.

    written: the text itself, if it is not in a file;
    outer: the place that brought this one into the graph, for example the stage that uses a graph file.
    """

    file: str
    line: int
    column: int
    width: int = 1
    written: str = ""
    outer: Place | None = None

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"

    def within(self, outer: Place) -> Place:
        """The place with one more at the end of its outer places."""
        return replace(self, outer=outer if self.outer is None else self.outer.within(outer))

    def beside(self, other: Place) -> Place:
        """The place with another one at the end of its outer places, without the outer places of that."""
        return self.within(replace(other, outer=None))

    @property
    def outer_places(self) -> tuple[Place, ...]:
        """The outer place, its outer place, and so on."""
        return () if self.outer is None else (self.outer, *self.outer.outer_places)


@dataclass(frozen=True)
class Guess:
    """'did you mean "x"?  NOUN: a, b, c' for an unknown word.

    The text is computed when it is shown, since comparing a word with all others is slow.
    """

    word: str
    noun: str
    known: Collection[str] = field(compare=False)

    @property
    def nearest(self) -> str:
        """The known word that is most like the unknown one, "" if none is like it."""
        names = sorted(self.known)[:MOST_COMPARED]
        near = difflib.get_close_matches(self.word[:_LONGEST_WORD], names, n=1, cutoff=0.6)
        return near[0] if near else ""

    def __str__(self) -> str:
        names, near = sorted(self.known), self.nearest
        guess = f'did you mean "{near}"?  ' if near else ""
        listing = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
        return f"{guess}{self.noun}: {listing or 'none'}"


@dataclass(frozen=True)
class Mistake:
    """One mistake: its place, what is wrong, and the remedy.

    warning: True if the graph can run all the same.
    """

    place: Place | None
    text: str
    help: str | Guess = ""
    warning: bool = False

    def __post_init__(self) -> None:
        """Shorten a text that quotes much of the user's input."""
        if len(self.text) > _LONGEST_TEXT:
            object.__setattr__(self, "text", _shortened(self.text))

    @property
    def remedy(self) -> str:
        """The remedy, in words."""
        return str(self.help)

    def __str__(self) -> str:
        return self.render()

    def render(self, lines_of: Callable[[str], Sequence[str]] | None = None) -> str:
        """The mistake as help: place and text, then the line with a caret and the remedy below it.

        lines_of: gives the lines of a file.
        """
        text, remedy = shown(self.text), shown(self.remedy)
        if self.place is None:
            return text + (f"\n    {remedy}" if remedy else "")
        lines = lines_of or _lines
        quoted = _quoted(self.place, remedy, lines) or (f"\n    {remedy}" if remedy else "")
        seen = [
            f"\n  see {shown(str(place))}{_quoted(place, '', lines)}" for place in self.place.outer_places
        ]
        return "".join([f"{shown(str(self.place))}: {text}", quoted, *seen])


class InputError(FollowspotError):
    """One or more mistakes in graph, room, placement or command line."""

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        super().__init__(mistakes)
        self.mistakes = tuple(mistakes)

    @classmethod
    def of(cls, text: str, remedy: str | Guess = "") -> InputError:
        """One mistake that has no place in a file."""
        return cls([Mistake(None, text, remedy)])

    def __str__(self) -> str:
        lines_of = lru_cache(maxsize=1)(_lines)  # mistakes stand together by file
        parts = [mistake.render(lines_of) for mistake in self.mistakes[:MOST_SHOWN]]
        more = len(self.mistakes) - MOST_SHOWN
        if more > 0:
            parts.append(f"and {more} more, which are shown when these are mended")
        return "\n".join(parts)


def warning_lines(warnings: Sequence[Mistake]) -> Iterator[str]:
    """The first warnings for a terminal, and how many more there are."""
    for mistake in warnings[:MOST_SHOWN]:
        yield f"warning: {mistake}"
    if len(warnings) > MOST_SHOWN:
        yield f"warning: and {len(warnings) - MOST_SHOWN} more"


def require_unused(path: Path, *sources: Path) -> None:
    """Raise InputError if there is a file that a command would replace: it may be the work of its user.

    sources: what the new file is made of; a command may be told to write back to one of them.
    """
    if path.exists() and not any(source.exists() and path.samefile(source) for source in sources):
        raise InputError.of(f"{path} is there already", "name another file, or remove it")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Raise FollowspotError for an OSError of the block; path: named in place of the OSError's
    file, which may be a temporary one, or none if the disk is full.
    """
    try:
        yield
    except OSError as error:
        raise FollowspotError(f"{path} cannot be written: {error.strerror}") from None


def did_you_mean(word: str, known: Collection[str], noun: str) -> Guess:
    """Suggestion for an unknown word; see `Guess`."""
    return Guess(word, noun, known)


def shown(text: str, most: int = _LONGEST_TEXT) -> str:
    """A text for a terminal: without control characters, and its middle left out if it is very long.

    most: characters of a text that is shown whole.
    """
    return printable_lines(_shortened(text, most))


def printable_lines(text: str) -> str:
    """A text of several lines without control characters."""
    return "\n".join(map(printable, text.split("\n")))


def printable(text: str) -> str:
    """A text on one line, with escapes in place of control characters: a sender could rewrite a terminal."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _shortened(text: str, most: int = _LONGEST_TEXT) -> str:
    """The text without its middle if it is longer than `most` characters."""
    if len(text) <= most:
        return text
    return f"{text[: most // 2]} ... {text[-most // 4 :]}"


def _window(line: str, column: int) -> tuple[str, int]:
    """The part of a line that is shown, and the column within it."""
    if not line.isprintable():
        line = "".join(c if c.isprintable() else " " for c in line)
    if len(line) <= _LONGEST_LINE:
        return line, column
    start = max(0, min(column - _LONGEST_LINE // 2, len(line) - _LONGEST_LINE))
    return line[start : start + _LONGEST_LINE], column - start


def _quoted(place: Place, remedy: str, lines_of: Callable[[str], Sequence[str]]) -> str:
    """The line of a place with a caret and the remedy below it; empty if it can no longer be read."""
    source = _line(place, lines_of)
    if source is None:
        return ""
    margin = f"{place.line:>5} | "
    line, column = _window(source, place.column)
    caret = " " * (column - 1) + "^" * max(1, min(place.width, len(line) - column + 1))
    return f"\n{margin}{line}\n{' ' * (len(margin) - 2)}| {caret} {remedy}".rstrip()


def _line(place: Place, lines_of: Callable[[str], Sequence[str]]) -> str | None:
    """The line of a place; None if the file can no longer be read."""
    lines = place.written.splitlines() if place.written else lines_of(place.file)
    return lines[place.line - 1] if 0 < place.line <= len(lines) else None


def _lines(file: str) -> Sequence[str]:
    """The lines of a document; none if it cannot be read."""
    try:
        return read_text(file, DOCUMENT, errors="replace").splitlines()
    except OSError:
        return ()
