"""A graph file with the files that it extends below it: keys and stages as trees of nodes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from pathlib import Path

from followspot.errors import InputError, Mistake, Place
from followspot.graph.compose.overlay import merged_mapping, merged_stages
from followspot.graph.plan import MAX_SEED
from followspot.yaml.form import Form, kind_of
from followspot.yaml.node import MAX_NODES, Node
from followspot.yaml.reader import read

MAX_FILES = 100
"""Most different files of one graph."""
MAX_USES = 1000
"""Most uses of files in one graph."""
MAX_LEVELS = 20
"""Most files that use each other in a chain."""
_INTERFACE = ("params", "inputs", "outputs")
_KEYS = ("graph", "extends", "room", "seed", *_INTERFACE, "stages")


@dataclass(frozen=True)
class GraphFile:
    """The content of a graph file, merged with the files that it extends.

    place: where it begins; params, inputs, outputs: its interface, by name; removed: stages of extended
    files that it removes, with the places that say so; paths: real paths of the files that lead to this one
    and of this one.
    """

    name: str
    place: Place
    paths: tuple[str, ...]
    room: Node | None = None
    seed: int | None = None
    params: Mapping[str, Node] = field(default_factory=dict)
    inputs: Mapping[str, Node] = field(default_factory=dict)
    outputs: Mapping[str, Node] = field(default_factory=dict)
    stages: Mapping[str, Node] = field(default_factory=dict)
    removed: Mapping[str, Place] = field(default_factory=dict)
    unreadable: frozenset[str] = frozenset()
    """Keys of the interface whose values are no mappings, so that the names are not known."""


class GraphFiles:
    """Reads the files of one graph, within limits.

    files: all that were read, in this order, each once.
    """

    def __init__(self, mistakes: list[Mistake], minor: list[Mistake]) -> None:
        """mistakes: receives those that leave stages or edges of the graph unknown; minor: the others."""
        self.mistakes = mistakes
        self.minor = minor
        self.files: list[Path] = []
        self._seen: set[str] = set()
        self._uses = 0
        self._nodes = 0
        self._full = False

    def root(self, path: Path) -> GraphFile:
        """The file of the graph itself. Raises InputError if it cannot be read."""
        remedy = "check the path; `followspot graphs` lists and copies the graphs that come with followspot"
        return self._read(path, (), None, remedy)

    def used(self, node: Node, key: str, above: tuple[str, ...], outer: Place) -> GraphFile | None:
        """The file that a node names below `key`; None if a mistake was noted.

        above: paths of the files that lead here; outer: the outer place of everything in the file.
        """
        value = node.value
        if not isinstance(value, str) or not value:
            self._fail(node.place, f"{key} names a graph file, not {kind_of(node)}", f"{key}: FILE.yaml")
            return None
        path = Path(node.place.file).parent / value
        real = _real(path)
        if real in above:
            ring = [*above[above.index(real) :], *_unless_last(above, node.place.file), real]
            chain = " -> ".join(Path(p).name for p in ring)
            self._fail(node.place, f"files use each other: {chain}", "remove one use")
            return None
        if len(above) >= MAX_LEVELS:
            text = f"files use each other more than {MAX_LEVELS} levels deep"
            self._fail(node.place, text, "make the graph flatter")
            return None
        new = real not in self._seen
        if len(self._seen) + new > MAX_FILES or self._uses >= MAX_USES or self._nodes > MAX_NODES:
            text = f"more than {MAX_FILES} files, {MAX_USES} uses of files or {MAX_NODES} values are used"
            if not self._full:
                self._fail(node.place, text, "make the graph smaller")
            self._full = True
            return None
        try:
            base = "the working folder" if node.place.file.startswith("--") else "this file"
            return self._read(path, above, outer, f"paths are relative to {base}", node.place)
        except InputError as error:
            self.mistakes += [_used_at(mistake, outer) for mistake in error.mistakes]
            return None

    def _read(
        self, path: Path, above: tuple[str, ...], outer: Place | None, remedy: str, at: Place | None = None
    ) -> GraphFile:
        """The file at a path, over those that it extends; counts it towards the limits. Raises InputError."""
        real = _real(path)
        self._uses += 1
        if real not in self._seen:
            self._seen.add(real)
            self.files.append(path)
        root = read(path, at=at, remedy=remedy)
        self._nodes += root.nodes
        form = Form(root if outer is None else _within(root, outer), "a graph", _KEYS, self.minor)
        interface = copy(form)
        interface.mistakes = self.mistakes
        own = GraphFile(
            name=form.title("graph") or path.stem,
            place=form.node.key,
            paths=(*above, real),
            room=form.get("room"),
            seed=form.whole("seed", least=0, most=MAX_SEED),
            params=interface.mapping("params"),
            inputs=interface.mapping("inputs"),
            outputs=interface.mapping("outputs"),
            stages=form.mapping("stages"),
            unreadable=frozenset(key for key in _INTERFACE if not _is_mapping(form.get(key))),
        )
        extends = form.get("extends")
        base = None
        if extends is not None:
            base = self.used(extends, "extends", own.paths, extends.place)
        return own if base is None else self._over(base, own, named="graph" in form.entries)

    def _over(self, base: GraphFile, own: GraphFile, *, named: bool) -> GraphFile:
        """A file merged with the one that it extends (`base`), whose entries it overrides.

        named: whether `own` has a name; else it gets that of `base`.
        """
        stages, removed = merged_stages(base.stages, own.stages, self.mistakes)
        gone = {**base.removed, **removed}
        return replace(
            own,
            name=own.name if named else base.name,
            room=own.room or base.room,
            seed=base.seed if own.seed is None else own.seed,
            params=merged_mapping(base.params, own.params),
            inputs=merged_mapping(base.inputs, own.inputs),
            outputs=merged_mapping(base.outputs, own.outputs),
            stages=stages,
            removed={name: place for name, place in gone.items() if name not in stages},
            unreadable=base.unreadable | own.unreadable,
        )

    def _fail(self, place: Place, text: str, remedy: str) -> None:
        self.mistakes.append(Mistake(place, text, remedy))


def _is_mapping(node: Node | None) -> bool:
    """Whether the value of a key is a mapping or missing."""
    return node is None or node.value is None or isinstance(node.value, Mapping)


def input_names(path: Path) -> frozenset[str]:
    """Names of the inputs in the interface of a graph file. Raises InputError if it cannot be read."""
    mistakes: list[Mistake] = []
    found = GraphFiles(mistakes, mistakes).root(path)
    if mistakes:
        raise InputError(mistakes)
    return frozenset(found.inputs)


def _used_at(mistake: Mistake, outer: Place) -> Mistake:
    """The mistake of a file together with the place that uses it, unless it stands in that file."""
    place = mistake.place
    inside = place is not None and place.file != outer.file
    return replace(mistake, place=place.within(outer)) if place is not None and inside else mistake


def _real(path: Path) -> str:
    return os.path.realpath(path) if "\0" not in str(path) else str(path)


def _unless_last(paths: tuple[str, ...], file: str) -> tuple[str, ...]:
    """The file in which a use stands, if it is an extended one and so not the last of the chain."""
    real = _real(Path(file))
    return () if paths[-1] == real or file.startswith("--") else (real,)


def _within(node: Node, outer: Place) -> Node:
    """The tree with an outer place everywhere."""
    value = node.value
    if isinstance(value, Mapping):
        value = {key: _within(inner, outer) for key, inner in value.items()}
    elif isinstance(value, tuple):
        value = tuple(_within(inner, outer) for inner in value)
    return replace(node, value=value, place=node.place.within(outer), key=node.key.within(outer))
