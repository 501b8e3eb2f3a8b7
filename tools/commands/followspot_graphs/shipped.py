"""The graphs that come with followspot, and the files each of them needs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

from followspot.errors import InputError, did_you_mean
from followspot.yaml.node import Node, child
from followspot.yaml.reader import read

_HERE = Path(__file__).parent
DEMO = "glowballs"


@dataclass(frozen=True)
class ShippedGraph:
    """A graph that comes with followspot.

    name: of its file, without .yaml; title: a sentence on its purpose; room: name of the room that it runs in
    if no other is given, or None.
    """

    name: str
    title: str
    room: str | None


def graphs_folder() -> Path:
    """The folder of the graphs: in the installed package, or in a checkout."""
    installed = _HERE / "shipped"
    return installed if installed.is_dir() else _HERE.parents[2] / "graphs"


def shipped_graphs() -> tuple[ShippedGraph, ...]:
    """All of them, by name."""
    return tuple(_described(path) for path in sorted(graphs_folder().glob("*.yaml")))


def graph_file(name: str) -> Path:
    """The file of a graph. Raises InputError if there is none of this name."""
    known = [path.stem for path in graphs_folder().glob("*.yaml")]
    name = name.removesuffix(".yaml")
    if name not in known:
        raise InputError.of(f'there is no graph "{name}"', did_you_mean(name, known, "graphs"))
    return graphs_folder() / f"{name}.yaml"


def files_of(graph: Path) -> list[Path]:
    """The file of a graph, its layouts for viewers, and those it names: room, graphs it uses, and theirs."""
    found = [graph]
    for path in found:  # grows while it is read
        found += [other for other in _named(path) if other not in found]
    return [*found, *sorted((graph.parent / "views").glob(f"{graph.stem}.*"))]


def _described(path: Path) -> ShippedGraph:
    room = child(_base(path), "room")
    return ShippedGraph(path.stem, _title(path), Path(str(room.value)).stem if room else None)


def _title(path: Path) -> str:
    """The first sentence of the comment that it begins with."""
    lines = takewhile(lambda line: line.startswith("# "), path.read_text(encoding="utf-8").splitlines())
    sentence, end, _ = " ".join(line.removeprefix("# ") for line in lines).partition(". ")
    return sentence + end.strip()


def _base(path: Path) -> Node | None:
    """The graph file that says which room it is: this one, or the one it extends."""
    document = read(path)
    extended = child(document, "extends")
    if child(document, "room") or extended is None:
        return document
    return _base(path.parent / str(extended.value))


def _named(path: Path) -> Iterator[Path]:
    """Files that a graph file names and that come with it."""
    document = read(path)
    stages = child(document, "stages")
    uses = stages.value.values() if stages and isinstance(stages.value, Mapping) else ()
    for node in (
        child(document, "extends"),
        child(document, "room"),
        *(child(stage, "graph") for stage in uses),
    ):
        if node and (path.parent / str(node.value)).is_file():
            yield path.parent / str(node.value)
