"""First step: the graph file with all that it uses, the overrides and the room, as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

from followspot.errors import InputError, Mistake, Place
from followspot.graph.compose.compose import ComposedGraph, compose
from followspot.graph.compose.interface_targets import StageTarget
from followspot.graph.compose.optional_use import OptionalUse
from followspot.graph.declaration import StageDeclaration, read_stage
from followspot.graph.override import read_overrides
from followspot.graph.room_part import part_of
from followspot.graph.subgraph_use import SubgraphUse
from followspot.room import Room
from followspot.room_document.room import room_of
from followspot.yaml.form import kind_of
from followspot.yaml.node import Node
from followspot.yaml.reader import read

MAX_STAGES = 1000


@dataclass(frozen=True)
class LoadedGraph:
    """The user's declarations with their places; no name has been looked up.

    room: empty if none is named, None if it has mistakes; room_node: its document, if there is one.
    """

    name: str
    room: Room | None
    room_node: Node | None
    seed: int
    stages: Mapping[str, StageDeclaration]
    offered: frozenset[str] = frozenset()
    """Stages that an interface names among its outputs."""
    interface_targets: tuple[StageTarget, ...] = ()
    """The targets that the interface of the graph file names."""
    left_out: Mapping[str, Mistake] = field(default_factory=dict)
    """The sub-graphs that the room has nothing for, with the reasons."""
    apart: tuple[StageDeclaration, ...] = ()
    """The stages of these."""
    optional: tuple[OptionalUse, ...] = ()
    """The other sub-graphs that may be left out."""
    tuned: frozenset[Place] = frozenset()
    """Of the tunes of the room that set parameters of sub-graphs."""
    outputs: Mapping[str, tuple[Node, ...]] = field(default_factory=dict)
    """The outputs of sub-graphs, SUBGRAPH.NAME, each with what feeds a reader of it."""
    subgraphs: tuple[SubgraphUse, ...] = ()


def load(
    path: str | Path,
    mistakes: list[Mistake],
    *,
    room: str | None = None,
    cameras: Sequence[str] = (),
    overrides: Sequence[str] = (),
) -> LoadedGraph:
    """Read a graph file; mistakes are noted.

    cameras: of the room, those that take part; all if there are none.
    Raises InputError if the files cannot be put together, for then the graph is not known.
    """
    composed, found, document = _composed(path, overrides, room, cameras, mistakes)
    if not composed.complete:
        raise InputError(mistakes)
    nodes = composed.stages
    if mistakes and not nodes:
        raise InputError(mistakes)
    if not 0 < len(nodes) <= MAX_STAGES:
        problem = f"the graph has {len(nodes)} stages, at most {MAX_STAGES} are read"
        problem = problem if nodes else _empty(composed)
        mistakes.append(Mistake(composed.place, problem, "stages: {NAME: {uses: ...}, ...}"))
    stages = {name: read_stage(name, node, mistakes) for name, node in islice(nodes.items(), MAX_STAGES)}
    return LoadedGraph(
        name=composed.name,
        room=found,
        room_node=document,
        seed=composed.seed,
        stages=stages,
        offered=composed.offered,
        interface_targets=composed.interface_targets,
        left_out=composed.left_out,
        apart=tuple(read_stage(name, node, mistakes) for name, node in composed.apart.items()),
        optional=composed.optional,
        tuned=composed.tuned,
        outputs=composed.outputs,
        subgraphs=composed.subgraphs,
    )


def _empty(composed: ComposedGraph) -> str:
    """Why a graph has no stages."""
    reasons = "; ".join([reason.text for reason in composed.left_out.values()][:6])
    return f"nothing is left of the graph: {reasons}" if reasons else "the graph has no stages"


def composed_graph(
    path: str | Path, *, room: str | None = None, cameras: Sequence[str] = (), overrides: Sequence[str] = ()
) -> ComposedGraph:
    """The stages of a graph file and of all that it uses; see `load`. Raises InputError."""
    mistakes: list[Mistake] = []
    composed, _, _ = _composed(path, overrides, room, cameras, mistakes)
    if mistakes:
        raise InputError(mistakes)
    return composed


def _composed(
    path: str | Path,
    overrides: Sequence[str],
    room: str | None,
    cameras: Sequence[str],
    mistakes: list[Mistake],
) -> tuple[ComposedGraph, Room | None, Node | None]:
    """The composed graph; the room and its document: see `Loaded.room`, `Loaded.room_node`."""
    changes = read_overrides(overrides, mistakes)
    found: tuple[Room | None, Node | None] = None, None

    def find_room(named: Node | None) -> tuple[Room | None, Node | None]:
        nonlocal found
        found = _room(room, named, cameras, mistakes)
        return found

    return compose(Path(path), changes, find_room, mistakes), *found


def _room(
    option: str | None, node: Node | None, cameras: Sequence[str], mistakes: list[Mistake]
) -> tuple[Room | None, Node | None]:
    """The room that the option names, else the graph: see `Loaded.room`, `Loaded.room_node`."""
    if option is not None:
        path, place = Path(option), Place("--room", 1, 1, max(1, len(option)), option)
    elif node is None:
        return Room(), None
    elif isinstance(node.value, str) and node.value:
        path, place = Path(node.place.file).parent / node.value, node.place
    else:
        mistakes.append(
            Mistake(node.place, f"room names a room file, not {kind_of(node)}", "room: FILE.yaml")
        )
        return None, None
    try:
        document = read(path, at=place, remedy="check the path, or use --room FILE")
        document = part_of(document, cameras, mistakes) if cameras else document
        return room_of(document, str(path.parent)), document
    except InputError as error:
        mistakes += error.mistakes
        return None, None
