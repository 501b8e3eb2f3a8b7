"""First step: the graph file, its includes, variables, overrides and room, as data."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

from followspot.document import MAX_NODES, Node, read
from followspot.errors import InputError, Mistake, Place
from followspot.form import Form, kind_of
from followspot.graph.declaration import StageDeclaration, read_stage
from followspot.graph.override import apply_to_stages, apply_to_vars, read_override
from followspot.graph.plan import MAX_SEED
from followspot.graph.variables import Variables
from followspot.room import Room
from followspot.room_form import room_of

MAX_FILES = 100
"""Most files that one graph may include."""
MAX_STAGES = 1000
_KEYS = ("graph", "room", "include", "vars", "seed", "stages")


@dataclass(frozen=True)
class Loaded:
    """The user's declarations with their places; no name has been looked up.

    room: empty if none is named, None if it has mistakes; room_node: its document, if there is one.
    """

    name: str
    room: Room | None
    room_node: Node | None
    seed: int
    stages: Mapping[str, StageDeclaration]


@dataclass
class _Text:
    """The parts of a graph, gathered file by file; an including file overrides its includes.

    files: real paths of all named files; nodes: of those that were read.
    """

    name: str = ""
    room: Node | None = None
    seed: int | None = None
    values: dict[str, Node] = field(default_factory=dict)
    stages: dict[str, Node] = field(default_factory=dict)
    files: set[str] = field(default_factory=set)
    nodes: int = 0


def load(
    path: str | Path, mistakes: list[Mistake], *, room: str | None = None, overrides: Sequence[str] = ()
) -> Loaded:
    """Read a graph file; mistakes are noted. Raises InputError if the file itself cannot be read."""
    text = _Text()
    root = read(path)
    _gather(root, Path(path), text, (), mistakes)
    changes = [change for option in overrides if (change := read_override(option, mistakes)) is not None]
    values = Variables(apply_to_vars(text.values, changes, mistakes), mistakes)
    nodes = apply_to_stages(text.stages, changes, mistakes)
    if not 0 < len(nodes) <= MAX_STAGES:
        problem = f"the graph has {len(nodes)} stages, at most {MAX_STAGES} are read"
        problem = problem if nodes else "the graph has no stages"
        mistakes.append(Mistake(root.key, problem, "stages: {NAME: {uses: ...}, ...}"))
    stages = {
        name: read_stage(name, values.substituted(node), mistakes)
        for name, node in islice(nodes.items(), MAX_STAGES)
    }
    found, document = _room(room, text.room and values.substituted(text.room), mistakes)
    return Loaded(text.name or Path(path).stem, found, document, text.seed or 0, stages)


def _gather(root: Node, path: Path, text: _Text, above: tuple[str, ...], mistakes: list[Mistake]) -> None:
    """Add a file's parts after those of its includes, which it overrides; above: the files that include
    it.
    """
    form = Form(root, "a graph", _KEYS, mistakes)
    above = (*above, os.path.realpath(path))
    text.files.add(above[-1])
    text.nodes += root.nodes
    for node in _includes(form):
        _include(path, node, text, above, mistakes)
    text.name = form.title("graph") or text.name
    seed = form.whole("seed", least=0, most=MAX_SEED)
    text.seed = text.seed if seed is None else seed
    text.room = form.get("room") or text.room
    text.values.update(form.mapping("vars"))
    for name, node in form.mapping("stages").items():
        if name in text.stages:
            first = text.stages[name].key
            remedy = f"first in {first.file}, line {first.line}; rename one"
            mistakes.append(Mistake(node.key, f'stage "{name}" is declared twice', remedy))
        else:
            text.stages[name] = node


def _includes(form: Form) -> tuple[Node, ...]:
    node = form.get("include")
    if node is None:
        return ()
    found = node.value if isinstance(node.value, tuple) else (node,)
    if len(found) > MAX_FILES:
        form.wrong(node, f"{len(found)} files are included, at most {MAX_FILES} are read", "join some")
    return found[:MAX_FILES]


def _include(path: Path, node: Node, text: _Text, above: tuple[str, ...], mistakes: list[Mistake]) -> None:
    if not isinstance(node.value, str) or not node.value:
        mistakes.append(
            Mistake(node.place, f"include names graph files, not {kind_of(node)}", "include: [FILE.yaml]")
        )
        return
    target = path.parent / node.value
    real = os.path.realpath(target) if "\0" not in node.value else node.value
    if real in above:
        chain = " -> ".join(Path(p).name for p in (*above[above.index(real) :], real))
        mistakes.append(Mistake(node.place, f"files include each other: {chain}", "remove one include"))
    elif len(text.files) >= MAX_FILES or text.nodes > MAX_NODES:
        most = f"more than {MAX_FILES} files or {MAX_NODES} values"
        mistakes.append(Mistake(node.place, f"{most} are included", "make the graph smaller"))
    elif real not in text.files:
        text.files.add(real)
        try:
            root = read(target, at=node.place, remedy="paths are relative to this file")
        except InputError as error:
            mistakes += error.mistakes
        else:
            _gather(root, target, text, above, mistakes)


def _room(option: str | None, node: Node | None, mistakes: list[Mistake]) -> tuple[Room | None, Node | None]:
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
        return room_of(document, str(path.parent)), document
    except InputError as error:
        mistakes += error.mistakes
        return None, None
