"""`--placement auto`: the workers that a model of the graph expects to be fastest, by measured work.

Only workers are chosen. Delays, codecs and parameters stay as they are written.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from followspot.graph.auto_placement.pipeline_model import PipelineModel, Timing

Aim = Literal["throughput", "latency"]
AIMS: tuple[Aim, ...] = ("throughput", "latency")
_WORTH = 0.03
"""Share that one more worker must gain: the model is not more exact than that."""
_PASSES = 6
_MOST_TRIED = 400
"""Placements that are tried at most."""
MAIN = "main"


@dataclass(frozen=True)
class PlacementUnit:
    """Instances that stay together: all that serve one camera or sensor, or one other instance.

    fixed: the worker that it has on another host, "" if it may be placed here.
    """

    name: str
    instances: tuple[str, ...]
    carrier: bool = False
    fixed: str = ""


@dataclass(frozen=True)
class Choice:
    """The chosen placement.

    worker_of: of each instance; here, alone: timings expected of it and of a single worker.
    """

    worker_of: Mapping[str, str]
    here: Timing
    alone: Timing

    @property
    def workers(self) -> tuple[str, ...]:
        """Names of the workers."""
        return tuple(dict.fromkeys(self.worker_of.values()))


class _Search:
    """Tries placements of units, each once. Deterministic: the same figures give the same choice."""

    def __init__(self, model: PipelineModel, units: Sequence[PlacementUnit], aim: Aim) -> None:
        self.model, self.units, self.aim = model, units, aim
        self.work = {unit.name: sum(model.work[name] for name in unit.instances) for unit in units}
        self.free = [unit for unit in units if not unit.fixed]
        self.timings: dict[tuple[int, ...], Timing] = {}

    def instances(self, numbers: tuple[int, ...]) -> dict[str, str]:
        """The worker of each instance. numbers: worker of each unit that is not fixed."""
        names = {unit.name: _worker(number) for unit, number in zip(self.free, numbers, strict=True)}
        return {name: unit.fixed or names[unit.name] for unit in self.units for name in unit.instances}

    def score(self, numbers: tuple[int, ...]) -> float:
        """The figure to minimise, ms; each further worker must gain `_WORTH`."""
        if numbers not in self.timings:
            self.timings[numbers] = self.model.timing(self.instances(numbers))
        timing = self.timings[numbers]
        figure = timing.period if self.aim == "throughput" else timing.latency
        return figure * (1.0 + _WORTH) ** (len(set(numbers)) - 1)

    def best(self) -> tuple[int, ...]:
        """The best start, improved by moving one unit at a time."""
        found = min(self.starts(), key=self.score)
        for _ in range(_PASSES):
            better = min(self.moves(found), key=self.score, default=found)
            if self.score(better) >= self.score(found):
                break
            found = better
        return found

    def starts(self) -> Iterator[tuple[int, ...]]:
        """Placements to start from.

        All units in one worker; cameras shared out over workers, with the other units in workers of their own
        or beside the fewest cameras.
        """
        yield tuple(0 for _ in self.free)
        carriers = [unit for unit in self.free if unit.carrier]
        for count in range(1, min(self.model.cores, len(carriers)) + 1):
            shared = self._shared(carriers, count)
            if count < self.model.cores:
                yield tuple(shared.get(unit.name, -1) + 1 for unit in self.free)
            yield tuple(shared.get(unit.name, 0) for unit in self.free)
        yield from self._cuts()

    def _shared(self, units: Iterable[PlacementUnit], count: int) -> dict[str, int]:
        """A worker for each unit, the most work first, to the worker with the least; 0 has the least."""
        load = [0.0] * count
        found = {}
        for unit in sorted(units, key=lambda unit: (-self.work[unit.name], unit.name)):
            least = min(range(count), key=lambda number: (load[number], number))
            load[least] += self.work[unit.name]
            found[unit.name] = least
        rank = {n: i for i, n in enumerate(sorted(range(count), key=lambda n: (load[n], n)))}
        return {name: rank[number] for name, number in found.items()}

    def _cuts(self) -> Iterator[tuple[int, ...]]:
        """The chain of stages in parts of equal work, one after the other."""
        order = sorted(self.free, key=lambda unit: min(self.model.order[name] for name in unit.instances))
        total = sum(self.work[unit.name] for unit in self.free)
        for count in range(2, min(self.model.cores, len(order)) + 1):
            done, part = 0.0, {}
            for unit in order:
                part[unit.name] = min(count - 1, int(count * done / total)) if total else 0
                done += self.work[unit.name]
            yield tuple(part[unit.name] for unit in self.free)

    def moves(self, numbers: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
        """Every placement in which one unit is in another worker."""
        count = len(set(numbers))
        for place in range(len(numbers)):
            for number in range(min(count + 1, self.model.cores)):
                if len(self.timings) >= _MOST_TRIED:
                    return
                if number != numbers[place]:
                    yield _renumbered((*numbers[:place], number, *numbers[place + 1 :]))


def choose(model: PipelineModel, units: Sequence[PlacementUnit], aim: Aim) -> Choice:
    """The workers from which the model expects most frame sets a second, or the least latency."""
    search = _Search(model, units, aim)
    found = search.best()
    alone = tuple(0 for _ in search.free)
    search.score(alone)
    return Choice(search.instances(found), search.timings[found], search.timings[alone])


def explained(choice: Choice, aim: Aim, cores: int, source: str) -> tuple[str, ...]:
    """Lines for the user: the chosen workers, the expected timing, and that of a single worker."""
    count = len(choice.workers)
    workers = "one worker" if count == 1 else f"{count} workers"
    here, alone = choice.here, choice.alone
    wanted = "most throughput" if aim == "throughput" else "least latency"
    lines = [
        f"placement auto, for {wanted}: {workers} on {cores} cores, by the work measured in {source}",
        f"expected: {_said(here)}" + (f"; in one worker {_said(alone)}" if count > 1 else ""),
    ]
    return (*lines, "delays and codecs are as written: a longer delay is yours to choose")


def _said(timing: Timing) -> str:
    return f"{timing.period:.2f} ms a frame set, {timing.latency:.2f} ms from source to sink"


def _worker(number: int) -> str:
    return f"{MAIN}{number + 1}" if number else MAIN


def _renumbered(numbers: tuple[int, ...]) -> tuple[int, ...]:
    """The placement with workers numbered in the order in which they come."""
    names: dict[int, int] = {}
    return tuple(names.setdefault(number, len(names)) for number in numbers)
