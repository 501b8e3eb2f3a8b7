"""Cells of one worker whose stages are alike and can work together, for less than each alone.

A member that is ready waits for the others, but never for anything from outside: the worker fires those that
are ready as soon as nothing else can go on. Who fires together never changes a result, for what a stage
returns together is what it returns alone.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any

from followspot.runtime.cell import Cell, Firing
from followspot.runtime.source import SourceCell


class Team:
    """Cells that fire together.

    mark: tells the worker to look at the cell of this rank again.
    """

    def __init__(self, cells: Sequence[Cell], mark: Callable[[int], None]) -> None:
        self.cells = tuple(cells)
        self.mark = mark
        self.waiting: dict[Cell, int] = {}
        """Members that are ready, with the capture time of their firing, ns."""
        self.living = {cell for cell in cells if not cell.done}

    def step(self, cell: Cell) -> None:
        """Look at a member; fire where all that have not ended are ready. Raises StageError.

        One that waits and is looked at again has got more to do: the others lag behind, and are left.
        """
        lags = cell in self.waiting
        fire_at = cell.due()
        if fire_at is not None:
            self.waiting[cell] = fire_at
        elif cell.done:
            self.living.discard(cell)
        else:
            return
        if lags or len(self.waiting) == len(self.living):
            self.fire()

    def fire(self) -> None:
        """Fire all that are ready. Raises StageError where the policy of one that raises is `fail`."""
        cells = list(self.waiting)
        firings = [cell.take(fire_at) for cell, fire_at in self.waiting.items()]
        self.waiting.clear()
        results = _together(cells, firings) if len(cells) > 1 else _each_alone(cells, firings)
        for cell, firing, result in zip(cells, firings, results, strict=True):
            cell.deliver(result, firing.header)
            if cell.has_more():
                self.mark(cell.rank)


def teams(cells: Sequence[Cell], mark: Callable[[int], None]) -> list[Team]:
    """Teams of two cells or more among the cells of a worker."""
    alike: dict[tuple[type, str], list[Cell]] = defaultdict(list)
    for cell in cells:
        if cell.stage.process_together is not None and not isinstance(cell, SourceCell):
            alike[type(cell.stage), cell.stage.params.model_dump_json()].append(cell)
    return [Team(members, mark) for members in alike.values() if len(members) > 1]


def _together(cells: Sequence[Cell], firings: Sequence[Firing]) -> Sequence[Any]:
    """What the stages return; where that raises, each works alone, so that the guilty one is named."""
    started = time.monotonic_ns()
    for cell in cells:
        cell.working = True
    try:
        together: Any = cells[0].stage.process_together
        results: Sequence[Any] = together([c.stage for c in cells], [f.arguments for f in firings])
        if len(results) != len(cells):
            raise ValueError(f"process_together returned {len(results)} outputs for {len(cells)} stages")
    except Exception as error:
        cells[0].stage.context.warn(f"each works alone, for together {type(error).__name__}: {error}")
        return _each_alone(cells, firings)
    finally:
        for cell in cells:
            cell.working = False
    share = (time.monotonic_ns() - started) // len(cells)
    for cell in cells:
        cell.count.busy_ns += share
    return results


def _each_alone(cells: Sequence[Cell], firings: Sequence[Firing]) -> Sequence[Any]:
    return [cell.run(firing) for cell, firing in zip(cells, firings, strict=True)]
