"""YAML files as trees of nodes with places; every mistake is reported at once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import yaml

from followspot.errors import InputError, Mistake, Place
from followspot.files import DOCUMENT, read_bytes
from followspot.yaml.node import Node
from followspot.yaml.tree_builder import DocumentTooLarge, TreeBuilder

VIDEOS = frozenset({".avi", ".m4v", ".mkv", ".mov", ".mp4", ".mpg", ".webm"})
"""Suffixes of videos, which people give where a room is expected."""


def read(path: str | Path, *, at: Place | None = None, remedy: str = "check the path") -> Node:
    """The tree of a YAML file. Raises InputError with every mistake.

    at, remedy: for a file that cannot be read: the place that names it, and advice. The advice for a video
    is to make a room of it.
    """
    file = str(path)
    if Path(path).suffix.lower() in VIDEOS:
        use = f"make a room of it: followspot room new --video {file} -o room.yaml"
        raise InputError([Mistake(at, f"{file} is a video, not a graph, room or placement", use)])
    try:
        data = read_bytes(path, DOCUMENT)
    except OSError as error:
        raise _one(at or Place(file, 1, 1), f"cannot read {file}: {error.strerror}", remedy) from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        place = _offset(file, data[: error.start].decode("utf-8-sig"))
        raise _one(place, "this byte is not UTF-8 text", "save the file as UTF-8") from None
    return parse(text, file)


def parse(text: str, file: str, written: str = "") -> Node:
    """The tree of a YAML text; `file` and `written` go into its places. Raises InputError."""
    builder = TreeBuilder(file, written)
    try:
        for event in yaml.parse(text, Loader=yaml.CSafeLoader):
            builder.take(event)
    except yaml.MarkedYAMLError as error:
        builder.mistakes.append(_syntax(error, text, file))
    except yaml.reader.ReaderError as error:
        head = text.encode()[: error.position].decode("utf-8", "ignore")
        place = _offset(file, head)
        builder.mistakes.append(Mistake(place, "this character is not allowed in YAML", "remove it"))
    except UnicodeEncodeError as error:
        place = _offset(file, text[: error.start])
        builder.mistakes.append(Mistake(place, "this character is not Unicode text", "remove it"))
    except DocumentTooLarge:
        pass  # it was noted when it was found
    if builder.mistakes:
        raise InputError(
            [replace(m, place=m.place and replace(m.place, written=written)) for m in builder.mistakes]
        )
    return builder.root or Node(None, Place(file, 1, 1), Place(file, 1, 1))


def _syntax(error: yaml.MarkedYAMLError, text: str, file: str) -> Mistake:
    """A mistake of YAML's own, at its place."""
    mark = error.problem_mark or error.context_mark
    problem = error.problem or "this is not YAML"
    lines = text.splitlines() or [""]
    if mark is None:
        place = Place(file, 1, 1)
    elif mark.line < len(lines):
        place = Place(file, mark.line + 1, mark.column + 1)
        if lines[mark.line][mark.column : mark.column + 1] == "\t":
            return Mistake(place, "a tab stands here, and YAML indents by spaces", "write spaces instead")
    else:  # libyaml points past the end of the file
        place = Place(file, len(lines), len(lines[-1]) + 1)
    return Mistake(place, f"not valid YAML: {problem}", _remedy(error))


def _remedy(error: yaml.MarkedYAMLError) -> str:
    mark = error.context_mark
    if error.context and mark is not None:
        return f"{error.context} that begins in line {mark.line + 1}, column {mark.column + 1}"
    return "check quotes, brackets and indentation"


def _offset(file: str, head: str) -> Place:
    lines = head.split("\n")
    return Place(file, len(lines), len(lines[-1]) + 1)


def _one(place: Place, text: str, remedy: str) -> InputError:
    return InputError([Mistake(place, text, remedy)])
