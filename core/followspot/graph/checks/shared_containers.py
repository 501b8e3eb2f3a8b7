"""Containers of a stage's class, which its instances share in one process and not in several."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from itertools import takewhile

from followspot.errors import Mistake
from followspot.graph.checks.flow import Flow
from followspot.stage import Stage


def shared_containers(flow: Flow) -> Iterator[Mistake]:
    """A warning for each empty container in the class of a stage: instances of other cameras, and later runs
    in this process, would share its entries. A container with entries may be a table that never changes.
    """
    for group in flow.groups.values():
        first = group[0]
        for name, kind in _containers(first.stage):
            text = (
                f"{first.instance.uses} keeps the {kind} {name} in its class, for all its instances and runs"
            )
            remedy = f"make it in setup(self): self.{name} = {kind}()"
            yield Mistake(first.instance.declared.place, text, remedy)


def _containers(stage: type[Stage]) -> Iterator[tuple[str, str]]:
    """Name and type of each empty container of the class and of its base classes."""
    for part in takewhile(lambda part: part is not Stage, stage.__mro__):
        for name, value in vars(part).items():
            if not name.startswith("__") and isinstance(value, list | dict | set | deque) and not value:
                yield name, type(value).__name__
