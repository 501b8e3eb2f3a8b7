"""Graphs with a mistake in their composition, and the one error that each gives.

¦ stands at the place of the error, ‡ at a place that is shown with it, each in front of the marked word.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, write
from tests.core.graph.files import ROOM, TOY

from followspot.errors import InputError, Mistake
from followspot.graph.compile import compile_graph

MAIN = """\
graph: building
room: room.yaml
stages:
  eyes: {uses: room.source, each: cameras}
  hall: {graph: middle.yaml, in: {frames: eyes}, with: {level: 0.75}}
  save: {uses: toy.save, in: {tracks: hall.tracks}}
"""
MIDDLE = """\
graph: middle
params: {level: inner.level}
inputs: {frames: inner.frames, hint: inner.hint}
outputs: {tracks: inner.tracks, forecast: inner.forecast}
stages:
  inner: {graph: tracker.yaml}
"""
FILES = {"main": MAIN, "middle": MIDDLE, "tracker": TRACKER, "room": ROOM}
Change = tuple[str, str, str]
"""A file, a part of its text, and what stands there instead."""


@dataclass(frozen=True)
class Wrong:
    """One mistake. over: the text of a file that extends main.yaml and is compiled instead."""

    changes: tuple[Change, ...]
    text: str
    remedy: str
    over: str = ""
    option: str = ""


def wrong(text: str, remedy: str, *changes: Change, over: str = "", option: str = "") -> Wrong:
    return Wrong(changes, text, remedy, over, option)


def marked(text: str, mark: str, file: str) -> list[tuple[str, int, int]]:
    """File, line and column of each mark."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        plain = line.replace("¦" if mark == "‡" else "‡", "")
        found += [(file, number, plain.index(mark) + 1)] if mark in plain else []
    return found


def compiled(folder: Path, case: Wrong) -> tuple[Mistake, ...]:
    files = {**FILES, **({"over": case.over} if case.over else {})}
    for name, old, new in case.changes:
        assert old in files[name], f"{name} has no {old!r}"
        files[name] = files[name].replace(old, new, 1)
    write(folder, **{name: text.replace("¦", "").replace("‡", "") for name, text in files.items()})
    options = [case.option.replace("¦", "")] if case.option else []
    with pytest.raises(InputError) as caught:
        compile_graph(
            folder / f"{'over' if case.over else 'main'}.yaml", overrides=options, plugin_files=[TOY]
        )
    return caught.value.mistakes


def check(folder: Path, case: Wrong) -> None:
    """Check that compiling gives one mistake, at the marks of the case."""
    found = compiled(folder, case)
    assert len(found) == 1, "\n".join(map(str, found))
    (mistake,) = found
    assert case.text in mistake.text
    assert case.remedy in mistake.remedy
    texts = {**FILES, "over": case.over}
    for name, old, new in case.changes:
        texts[name] = texts[name].replace(old, new, 1)
    marks = {
        mark: [
            *(place for name, text in texts.items() for place in marked(text, mark, f"{name}.yaml")),
            *marked(case.option, mark, "--set"),
        ]
        for mark in "¦‡"
    }
    place = mistake.place
    assert place is not None
    assert [(Path(place.file).name, place.line, place.column)] == marks["¦"]
    seen = {(Path(p.file).name, p.line, p.column) for p in place.outer_places}
    assert seen >= set(marks["‡"]), str(mistake)
    shown = mistake.render()
    assert all(f"see {folder / file}:{line}:{column}" in shown for file, line, column in marks["‡"])
