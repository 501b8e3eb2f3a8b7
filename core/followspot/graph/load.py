"""First step: the graph file with what it includes, its variables, the overrides and its room, as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from followspot.document import Node, read
from followspot.errors import InputError, Mistake, Place
from followspot.form import Form, kind_of
from followspot.graph.declaration import StageDeclaration, read_stage
from followspot.graph.override import apply_to_stages, apply_to_vars, read_override
from followspot.graph.plan import MAX_SEED
from followspot.graph.variables import substitute
from followspot.room import Room
from followspot.room_form import room_of

MAX_FILES = 100
"""Most files that one graph may include."""
MAX_STAGES = 1000
_KEYS = ("graph", "room", "include", "vars", "seed", "stages")


@dataclass(frozen=True)
class Loaded:
    """What the user wrote, every word in its place; nothing was looked up yet.

    room: empty where none is named, None where it has mistakes; room_node: its document, if there is one.
    """

    name: str
    room: Room | None
    room_node: Node | None
    seed: int
    stages: Mapping[str, StageDeclaration]


@dataclass
class _Text:
    """The parts of a graph, gathered file by file; what an including file says counts."""

    name: str = ""
    room: Node | None = None
    seed: int | None = None
    values: dict[str, Node] = field(default_factory=dict)
    stages: dict[str, Node] = field(default_factory=dict)
    files: set[Path] = field(default_factory=set)


def load(
    path: str | Path, mistakes: list[Mistake], *, room: str | None = None, overrides: Sequence[str] = ()
) -> Loaded:
    """Read a graph file; mistakes are noted. Raises InputError where the file itself cannot be read."""
    text = _Text()
    root = _gather(Path(path), text, (), mistakes)
    changes = [change for option in overrides if (change := read_override(option, mistakes)) is not None]
    values = apply_to_vars(text.values, changes, mistakes)
    nodes = apply_to_stages(text.stages, changes, mistakes)
    stages = {
        name: read_stage(name, substitute(node, values, mistakes), mistakes) for name, node in nodes.items()
    }
    if not 0 < len(stages) <= MAX_STAGES:
        problem = "the graph has no stages" if not stages else f"the graph has more than {MAX_STAGES} stages"
        mistakes.append(Mistake(root.key, problem, "stages: {NAME: {uses: ...}, ...}"))
    found, document = _room(room, text.room and substitute(text.room, values, mistakes), mistakes)
    return Loaded(text.name or Path(path).stem, found, document, text.seed or 0, stages)


def _gather(path: Path, text: _Text, above: tuple[Path, ...], mistakes: list[Mistake]) -> Node:
    """Take a file's parts in, those of its includes first, so that its own prevail. Raises InputError."""
    root = read(path)
    form = Form(root, "a graph", _KEYS, mistakes)
    text.files.add(path.resolve())
    for node in _includes(form):
        _include(path, node, text, (*above, path.resolve()), mistakes)
    text.name = form.text("graph") or text.name
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
    return root


def _includes(form: Form) -> tuple[Node, ...]:
    node = form.get("include")
    if node is None:
        return ()
    return node.value if isinstance(node.value, tuple) else (node,)


def _include(path: Path, node: Node, text: _Text, above: tuple[Path, ...], mistakes: list[Mistake]) -> None:
    if not isinstance(node.value, str) or not node.value:
        mistakes.append(
            Mistake(node.place, f"include names graph files, not {kind_of(node)}", "include: [FILE.yaml]")
        )
        return
    target = path.parent / node.value
    if target.resolve() in above:
        chain = " -> ".join(p.name for p in (*above[above.index(target.resolve()) :], target))
        mistakes.append(Mistake(node.place, f"files include each other: {chain}", "remove one include"))
    elif not target.is_file():
        mistakes.append(
            Mistake(node.place, f"there is no graph file {target}", "paths are relative to this file")
        )
    elif len(text.files) >= MAX_FILES:
        mistakes.append(Mistake(node.place, f"more than {MAX_FILES} files are included", "join some"))
    elif target.resolve() not in text.files:
        try:
            _gather(target, text, above, mistakes)
        except InputError as error:
            mistakes += error.mistakes


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
    if not path.is_file():
        mistakes.append(Mistake(place, f"there is no room file {path}", "check the path, or use --room FILE"))
        return None, None
    try:
        document = read(path)
        return room_of(document, str(path.parent)), document
    except InputError as error:
        mistakes += error.mistakes
        return None, None
