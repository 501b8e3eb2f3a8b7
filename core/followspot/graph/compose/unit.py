"""A graph file in use: the graph itself, or a sub-graph of it with its parameters and inputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from followspot.errors import Mistake, Place
from followspot.graph.compose.graph_file import GraphFile
from followspot.graph.compose.interface import Interface
from followspot.graph.compose.narrowing import Limit
from followspot.yaml.node import Node


@dataclass(frozen=True)
class WiredInput:
    """The feeds of an input. unit: the feeds name stages of this unit."""

    unit: Unit
    feeds: Node


@dataclass
class Unit:
    """One use of a graph file.

    name: of the sub-graph, "" for the graph itself; stages: as in the file, with the parameters that the use
    gives; wired: inputs of these stages that the use connects; replaced: stages that a connected input of
    the interface replaces; limits: the cameras or members that the use, and those around it, serve; units:
    the sub-graphs among the stages, several for one that fans out.
    """

    name: str
    file: GraphFile
    interface: Interface
    stages: dict[str, Node]
    limits: tuple[Limit, ...] = ()
    wired: dict[tuple[str, str], WiredInput] = field(default_factory=dict)
    replaced: dict[str, WiredInput] = field(default_factory=dict)
    units: dict[str, tuple[Unit, ...]] = field(default_factory=dict)
    left_out: dict[str, Mistake] = field(default_factory=dict)
    """The optional sub-graphs whose cameras or members the room lacks, by name, with the reasons."""
    apart: dict[str, Unit] = field(default_factory=dict)
    """The units of these, made as if the room was unknown, so that their files are checked all the same."""
    optional: Place | None = None
    """The place of `optional: true` in the use; None for a use that may not be left out."""
    inputs: Mapping[str, WiredInput] = field(default_factory=dict)
    """The inputs of the interface that the use connects."""
    given: Mapping[str, Node] = field(default_factory=dict)
    """The parameters of the interface that the use gives."""
