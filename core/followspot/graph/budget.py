"""Budgets of paths: the longest time from a source to the end of a stage, as a placement file writes it."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Annotated

from pydantic import Field

from followspot.errors import Mistake, did_you_mean
from followspot.graph.cycles import successors
from followspot.yaml.form import kind_of
from followspot.yaml.node import Node

_PATH = re.compile(r"\s*(?P<origin>\S+)\s*->\s*(?P<end>\S+)\s*")
_TIME = re.compile(r"(?P<number>\d{1,6}(\.\d{1,6})?)\s*(?P<unit>us|ms|s)")
_UNITS = {"us": 1e-6, "ms": 1e-3, "s": 1.0}
LONGEST = 60.0
"""Longest budget, s."""
_REMEDY = "write for example 20 ms"


@dataclass(frozen=True)
class Budget:
    """The longest time, s, from a message's entering the graph until a stage has worked on it.

    origin, end: stages of the graph file; every instance of `end` keeps the budget.
    """

    origin: str
    end: str
    limit: Annotated[float, Field(gt=0, le=LONGEST)]
    written: str = field(default="", compare=False)
    """The path as the placement file writes it; known to the operator only."""

    @property
    def name(self) -> str:
        """Shown to users: ``camera -> track``."""
        return f"{self.origin} -> {self.end}"

    @property
    def limit_ms(self) -> float:
        """The limit, ms."""
        return round(self.limit * 1e3, 6)


def read_budgets(
    entries: Mapping[str, Node],
    stages: Collection[str],
    wires: Collection[tuple[str, str]],
    mistakes: list[Mistake],
) -> tuple[Budget, ...]:
    """The budgets of a placement file; notes mistakes.

    entries: PATH: TIME; stages: of the graph file; wires: from and to, feedback left out.
    """
    found = []
    for text, node in entries.items():
        path = _path(text, node, stages, wires, mistakes)
        limit = _limit(node, mistakes)
        if path is not None and limit is not None:
            found.append(Budget(*path, limit, text))
    return tuple(found)


def _path(
    text: str,
    node: Node,
    stages: Collection[str],
    wires: Collection[tuple[str, str]],
    mistakes: list[Mistake],
) -> tuple[str, str] | None:
    """Origin and end of a path that is there."""

    def wrong(said: str, remedy: object) -> None:
        mistakes.append(Mistake(node.key, said, remedy))  # type: ignore[arg-type]

    match = _PATH.fullmatch(text)
    if match is None:
        wrong(f'"{text}" is no path', "write SOURCE -> STAGE: TIME")
        return None
    origin, end = match["origin"], match["end"]
    for name in (origin, end):
        if name not in stages:
            wrong(f'there is no stage "{name}"', did_you_mean(name, stages, "stages"))
            return None
    fed = {target for _, target in wires}
    if origin in fed:
        sources = [name for name in stages if name not in fed]
        wrong(f'a budget begins at a source, and "{origin}" is none', f"sources: {', '.join(sources)}")
        return None
    if end not in reachable(origin, wires) - {origin}:
        wrong(f"no path leads from {origin} to {end}", "name a stage that its messages come to")
        return None
    return origin, end


def reachable(origin: str, pairs: Iterable[tuple[str, str]]) -> set[str]:
    """The origin and all that follows it. pairs: from and to."""
    pairs = list(pairs)
    following = successors(dict.fromkeys(name for pair in pairs for name in pair), pairs)
    found, waiting = {origin}, [origin]
    while waiting:
        new = [name for name in following.get(waiting.pop(), ()) if name not in found]
        found.update(new)
        waiting += new
    return found


def _limit(node: Node, mistakes: list[Mistake]) -> float | None:
    """The time, s."""
    match = _TIME.fullmatch(node.value.strip()) if isinstance(node.value, str) else None
    if match is None:
        mistakes.append(Mistake(node.place, f"a budget is a time, not {kind_of(node)}", _REMEDY))
        return None
    limit = float(match["number"]) * _UNITS[match["unit"]]
    if not 0.0 < limit <= LONGEST:
        mistakes.append(Mistake(node.place, f"a budget cannot be {node.value}", f"{_REMEDY}; at most 60 s"))
        return None
    return limit
