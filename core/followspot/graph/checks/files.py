"""Lets each stage check the files and members of the room that its parameters name (`Stage.check_files`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from followspot.errors import InputError, Mistake, Place
from followspot.graph.instances import CheckedStage
from followspot.graph.parameters import path_parameters
from followspot.room import Room
from followspot.stage_params import PathIn


def check_files(stages: Sequence[CheckedStage], room: Room, mistakes: list[Mistake]) -> list[Mistake]:
    """Note what stages find in their files: at the place in the file, together with that of the path.

    Returns the warnings among them.
    """
    warnings: list[Mistake] = []
    for checked in stages:
        for mistake in _found(checked, room):
            place = _place(checked, mistake)
            at = place if mistake.place is None else mistake.place.within(place)
            (warnings if mistake.warning else mistakes).append(replace(mistake, place=at))
    return warnings


def _found(checked: CheckedStage, room: Room) -> Iterator[Mistake]:
    """The result of `check_files`; that it fails is a mistake itself."""
    params = checked.stage.Params(**checked.params)
    try:
        yield from checked.stage.check_files(params, room, checked.instance.member)
    except InputError as error:
        yield from error.mistakes
    except Exception as error:  # the code of a plugin may do anything
        text = f"{checked.instance.uses}.check_files failed: {type(error).__name__}: {error}"
        yield Mistake(None, text, "tell the author of the plugin")


def _place(checked: CheckedStage, mistake: Mistake) -> Place:
    """The place of the parameter that the mistake names, else of the first path, else of the stage."""
    written = checked.instance.params
    named = written.get(mistake.text.partition(": ")[0])
    if named is not None:
        return named.place
    paths = [name for name in path_parameters(checked.stage.Params, PathIn) if name in written]
    return written[paths[0]].place if paths else checked.instance.declared.place
