"""Checks the files that stages write: no two stages write one path, and none writes below a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePath

from followspot.errors import Mistake, Place
from followspot.files import RUN_LOG
from followspot.graph.instances import CheckedStage, Instance
from followspot.graph.parameters import output_files, output_paths

_Writers = dict[str, list[Instance]]
"""The stages that write each path."""


def check_outputs(stages: Sequence[CheckedStage], mistakes: list[Mistake]) -> None:
    """Two stages must not write one file, nor the log of the run, nor below what is a file."""
    writers: _Writers = {}
    files: dict[str, Instance] = {}
    for checked in stages:
        for path in output_paths(checked.stage.Params, checked.params):
            found = writers.setdefault(path, [])
            found += [checked.instance] if checked.instance not in found else []
        files |= dict.fromkeys(output_files(checked.stage.Params, checked.params), checked.instance)
    for path, (first, *others) in writers.items():
        if path == RUN_LOG:
            text = f'stage "{first.name}" writes {path}, which is the log of the run'
            mistakes.append(Mistake(_place(first, path), text, "give it another path"))
        mistakes += _below_a_file(first, path, files)
        if others:
            place = _beside(_place(others[0], path), first.declared.place)
            more = f" and {len(others) - 1} more" if len(others) > 1 else ""
            text = f'stages "{first.name}" and "{others[0].name}"{more} write the same file {path}'
            mistakes.append(Mistake(place, text, "give each its own path"))


def _below_a_file(writer: Instance, path: str, files: Mapping[str, Instance]) -> Iterator[Mistake]:
    """A mistake if a folder of the path is a file of a stage, or the log. files: with the stage of each."""
    for folder in map(str, PurePath(path).parents):
        owner = f'the file of stage "{files[folder].name}"' if folder in files else "the log of the run"
        if folder in files or folder == RUN_LOG:
            text = f'stage "{writer.name}" writes {path}, but {folder} is {owner} and no folder'
            yield Mistake(_place(writer, path), text, "give it a path in another folder")


def _place(writer: Instance, path: str) -> Place:
    """Where the path is written, or the stage if it is a default."""
    node = next((node for node in writer.params.values() if node.value == path), None)
    return writer.declared.place if node is None else node.place


def _beside(place: Place, other: Place) -> Place:
    """The place, together with what is at the other one and not here: the line, or the use of its file."""
    here = {(one.file, one.line) for one in (place, *place.outer_places)}
    apart = (one for one in (other, *other.outer_places) if (one.file, one.line) not in here)
    return next((place.beside(one) for one in apart), place)
