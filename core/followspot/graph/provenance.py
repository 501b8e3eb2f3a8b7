"""The provenance of a plan: the files that it was made of, and the origin of each parameter's value."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ParameterOrigin:
    """The origin of a parameter's value. kept: `--set` or a change gave it, so a tune does not replace it."""

    text: str
    kept: bool = False


@dataclass(frozen=True)
class SourceFiles:
    """The files from which a plan was compiled, as absolute paths.

    room: "" for the graph's own; cameras: the part of the room that takes part, all if there are none.
    """

    graph: str
    room: str = ""
    cameras: tuple[str, ...] = ()
