"""A graph file in the place of a stage, with all names resolved, as a running graph keeps it.

No value of a parameter is in it, so that every host of a run may have it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from followspot.room import Member


@dataclass(frozen=True)
class SubgraphUse:
    """One use of a file.

    name: full name, ``tracker/hall``; stage: of the entry in the graph file, ``tracker``, which is the same
    unless it fans out; inputs: those that are connected, with flat feeds as a graph file writes them;
    cameras: the selectors, and members: the members that it is limited to; params: the stages and parameters
    that each parameter of the interface sets, ``hall/color.similarity``; given: parameters that the graph
    gives, with True for those that `--set` gave.
    """

    name: str
    stage: str
    inputs: Mapping[str, list[Any]] = field(default_factory=dict)
    cameras: tuple[str, ...] = ()
    members: tuple[Member, ...] = ()
    params: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    given: Mapping[str, bool] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, str]:
        """The names by which it is set and swapped."""
        return self.name, self.stage

    def holds(self, stage: str) -> bool:
        """True if a stage or another use is below this one. stage: its full name."""
        return stage.startswith(f"{self.name}/")


def is_given_by_set(uses: Iterable[SubgraphUse], parameter: str) -> bool:
    """True if `--set` gave a parameter of a stage, STAGE.PARAMETER, by that of a sub-graph."""
    return any(
        by_set and parameter in use.params.get(name, ()) for use in uses for name, by_set in use.given.items()
    )
