"""The interface of a graph file: its parameters, inputs and outputs, and their targets inside."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from followspot.errors import Mistake, did_you_mean
from followspot.graph.compose.feeds import items, sender
from followspot.graph.compose.graph_file import GraphFile
from followspot.valid_values.names import is_name
from followspot.yaml.form import kind_of
from followspot.yaml.node import Node

_FORMS = {
    "params": "STAGE.PARAMETER, or a list of them",
    "inputs": "STAGE, STAGE.PORT, or a list of them",
    "outputs": "STAGE or STAGE.PORT",
}
SECTION = {"parameter": "params", "input": "inputs", "output": "outputs"}
"""The key of a graph file that lists what a word stands for."""


@dataclass(frozen=True)
class InterfaceTarget:
    """A stage inside, and one of its parameters or ports; node: the text that names it."""

    stage: str
    name: str | None
    node: Node

    @property
    def text(self) -> str:
        """The target as it is written."""
        return str(self.node.value)


@dataclass(frozen=True)
class Interface:
    """The targets inside of each name of the interface; none if a mistake was noted."""

    params: Mapping[str, tuple[InterfaceTarget, ...]]
    inputs: Mapping[str, tuple[InterfaceTarget, ...]]
    outputs: Mapping[str, tuple[InterfaceTarget, ...]]


def read_interface(file: GraphFile, mistakes: list[Mistake]) -> Interface:
    """Note names that cannot be read, and targets that are no stages of the file."""
    return Interface(
        dict(_read("params", file.params, file, mistakes)),
        dict(_read("inputs", file.inputs, file, mistakes)),
        dict(_read("outputs", file.outputs, file, mistakes)),
    )


def _read(
    key: str, entries: Mapping[str, Node], file: GraphFile, mistakes: list[Mistake]
) -> Iterator[tuple[str, tuple[InterfaceTarget, ...]]]:
    """Each name of one section of the interface, with its targets."""
    for name, node in entries.items():
        if not is_name(name):
            text = f'"{name}" cannot be a name among the {key}'
            mistakes.append(Mistake(node.key, text, "use 1 to 100 letters, digits, _ and -"))
        listed = items(node)
        if not listed or (key == "outputs" and len(listed) > 1):
            mistakes.append(_malformed(key, name, node))
            listed = ()
        found = [_target(key, name, item, file, mistakes) for item in listed]
        yield name, tuple(target for target in found if target is not None)


def _target(
    key: str, name: str, node: Node, file: GraphFile, mistakes: list[Mistake]
) -> InterfaceTarget | None:
    """The target that a text names; None if a mistake was noted."""
    named = sender(node) if isinstance(node.value, str) else None
    if named is None or (key == "params" and named[1] is None):
        mistakes.append(_malformed(key, name, node))
        return None
    if named[0] in file.removed:
        return None  # which is a mistake of its own
    if named[0] not in file.stages:
        text = f'{key}: {name} names the stage "{named[0]}", which the graph lacks'
        mistakes.append(Mistake(node.place, text, did_you_mean(named[0], file.stages.keys(), "stages")))
        return None
    return InterfaceTarget(named[0], named[1], node)


def _malformed(key: str, name: str, node: Node) -> Mistake:
    text = f"{key}: {name} stands for {_FORMS[key]}, not {kind_of(node)}"
    return Mistake(node.place, text, f"{key}: {{{name}: STAGE.{'PARAMETER' if key == 'params' else 'PORT'}}}")
