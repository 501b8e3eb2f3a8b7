"""Instances of stages, and the edges between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from followspot.errors import Place
from followspot.graph.declaration import Feed, StageDeclaration
from followspot.room import Member
from followspot.stage import Stage
from followspot.yaml.node import Node

ANY = Member("", "?")
"""Stands for the members of a room that has mistakes, so that the rest of the graph is still checked."""


@dataclass(frozen=True)
class Instance:
    """One instance of a stage. uses is empty if a mistake left it unknown."""

    name: str
    declared: StageDeclaration
    member: Member | None
    uses: str
    uses_place: Place
    params: Mapping[str, Node]
    tuned: frozenset[str] = frozenset()
    """The parameters that the room tunes."""


@dataclass(frozen=True)
class CheckedStage:
    """An instance with its class and its validated parameters in JSON types."""

    instance: Instance
    stage: type[Stage]
    params: Mapping[str, Any]

    @property
    def tolerance(self) -> float:
        """Largest difference in capture time of joined messages, s: the graph's, or the stage's own."""
        written = self.instance.declared.tolerance
        return self.stage.join_tolerance if written is None else written


@dataclass(frozen=True)
class Wire:
    """An edge from an instance to an input port of another; its output port may not be known yet."""

    source: Instance
    feed: Feed
    target: Instance
    port: str
    port_place: Place


Groups = Mapping[str, Mapping[Member | None, Instance]]
"""The instances of each stage, by member."""
