"""Errors and warnings in the words of scripts: keywords of `run` where the command line has options."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from followspot.errors import FollowspotError, Guess, InputError, Mistake, Place

_NETWORK = ("connect", "listen", "discover", "router", "certificates", "insecure")
_RUN = ("out", "room", "cameras", "set", "placement", "frames", "seed", "edges", "restart", "media", "keep")
_KEYWORDS = {
    "plugin": "plugin_files",
    **{name: name for name in _RUN},
    **{name: f"network=Network({name}=...)" for name in _NETWORK},
}
"""Keywords of `run` by the options of `followspot run` that they stand for."""
_OPTION = re.compile(r"followspot [a-z][^`,;\n]*|--([a-z]+)\b(?!-)(?: (?=[\w./])|(?=:))?")
"""A command, which stays as it is, or an option."""
_CAMERAS = re.compile(r"--cameras (\w[\w,-]*)")
_VALUES = re.compile(r"(followspot [a-z][^`,;\n]*)|--(keep|placement) ([\w:./-]*\w)")
"""A command, which stays as it is, or an option whose value is a text."""
_SETTINGS = re.compile(r"--set ([\w./]+)=([\w.]+)(?: (?=--set [\w./]+=))?")
"""A parameter and its value; with the space before another one."""


def in_python(text: str) -> str:
    """A text with keywords in place of options: "choose another with out="."""

    def keyword(found: re.Match[str]) -> str:
        name = _KEYWORDS.get(found[1] or "")
        if name is None:
            return found[0]
        if "=" in name:
            return name + found[0][len(found[0].rstrip()) :]
        return name if found.string[found.end() : found.end() + 1] == ":" else f"{name}="

    settings = _SETTINGS.sub(r'set={"\1": \2}', text).replace("}set={", ", ")
    return _OPTION.sub(keyword, _VALUES.sub(_quoted, _CAMERAS.sub(_listed, settings)))


def _quoted(found: re.Match[str]) -> str:
    command, name, value = found.groups()
    return command or f'{name}="{value}"'


def _listed(cameras: re.Match[str]) -> str:
    return f"cameras={cameras[1].split(',')}"


def mistakes_in_python(mistakes: Sequence[Mistake]) -> tuple[Mistake, ...]:
    """The same mistakes, with keywords in place of options in texts, remedies and places."""
    return tuple(map(_mistake, mistakes))


@contextmanager
def errors_in_python() -> Iterator[None]:
    """Raise the errors of the block, in which options of the command line are named, with keywords."""
    try:
        yield
    except InputError as error:
        raise InputError(mistakes_in_python(error.mistakes)) from None
    except FollowspotError as error:
        error.args = tuple(in_python(part) if isinstance(part, str) else part for part in error.args)
        raise


def _mistake(mistake: Mistake) -> Mistake:
    remedy = mistake.help if isinstance(mistake.help, Guess) else in_python(mistake.help)
    return replace(mistake, place=_place(mistake.place), text=in_python(mistake.text), help=remedy)


def _place(place: Place | None) -> Place | None:
    """The place; that of an option gets the name of its keyword."""
    if place is None:
        return None
    name = _KEYWORDS.get(place.file.removeprefix("--")) if place.file.startswith("--") else None
    return replace(place, file=name or place.file, outer=_place(place.outer))
