"""Mistakes in what a user wrote, with the place, the line itself and the remedy."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path


class FollowspotError(Exception):
    """Base of every error that is the user's to mend; its text is shown without a traceback."""


@dataclass(frozen=True)
class Place:
    """A position in a file or on the command line; line and column count from 1.

    written: the text itself, where it stands in no file.
    """

    file: str
    line: int
    column: int
    width: int = 1
    written: str = ""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Mistake:
    """One mistake: where, what is wrong, and what to do."""

    place: Place | None
    text: str
    remedy: str = ""

    def render(self) -> str:
        """The mistake as help: place and text, then the line with a caret and the remedy below it."""
        if self.place is None:
            return self.text + (f"\n    {self.remedy}" if self.remedy else "")
        head = f"{self.place}: {self.text}"
        source = _line(self.place)
        if source is None:
            return head + (f"\n    {self.remedy}" if self.remedy else "")
        margin = f"{self.place.line:>5} | "
        caret = " " * (self.place.column - 1) + "^" * max(1, self.place.width)
        return f"{head}\n{margin}{source}\n{' ' * (len(margin) - 2)}| {caret} {self.remedy}".rstrip()


class InputError(FollowspotError):
    """One or more mistakes in graph, room, placement or command line."""

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        self.mistakes = tuple(mistakes)
        super().__init__("\n".join(m.render() for m in self.mistakes))


def did_you_mean(word: str, known: Iterable[str], noun: str) -> str:
    """'did you mean "x"?  NOUN: a, b, c' for a word that is none of the known ones."""
    names = sorted(known)
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    guess = f'did you mean "{near[0]}"?  ' if near else ""
    listing = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
    return f"{guess}{noun}: {listing or 'none'}"


def _line(place: Place) -> str | None:
    try:
        text = place.written or Path(place.file).read_text(encoding="utf-8", errors="replace")
    except (OSError, ValueError):
        return None
    lines = text.splitlines()
    return lines[place.line - 1] if 0 < place.line <= len(lines) else None
