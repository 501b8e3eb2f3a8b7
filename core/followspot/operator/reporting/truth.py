"""Scores the outputs of a run against the ground truth that its room declares."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from followspot.context import Context
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.operator.reporting.scored import scored_file, written_tables
from followspot.plugins.loaded_hooks import load_scorers
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.scoring import Score, Scoring
from followspot.stage import Stage

T = TypeVar("T")


def run_scores(plan: Plan, out: Path, frames: int, seconds: float = math.inf) -> dict[str, Score]:
    """Scores of the outputs of a run, by the name of the scorer; empty without truth or such outputs.

    Raises the errors of :func:`room_truth`.
    """
    found = _scoring(plan)
    if found is None:
        return {}
    name, scoring = found
    file = scored_file(plan, scoring.messages)
    if file is None or not (out / file).exists():
        return {}
    return {name: scoring.score(out / file, room_truth(plan, frames, seconds), plan.room)}


def scorable(plan: Plan) -> tuple[Path, ...]:
    """The files of a run that could be scored; the first is. Empty if there is no truth."""
    found = _scoring(plan)
    return () if found is None else written_tables(plan, found[1].messages)


def room_truth(plan: Plan, frames: int | None = None, seconds: float = math.inf) -> Any:
    """The ground truth of the room's first `frames` frames, or of all, as its scorer reads it.

    None if the room declares none, or no scorer reads it. A source that normally waits between frames does
    not wait here. Raises the errors of the truth's source, and FollowspotError if reading takes longer than
    `seconds`.
    """
    found, use = _scoring(plan), plan.room.truth
    if found is None or use is None:
        return None
    context = Context(name="truth", room=plan.room, seed=plan.seed, pause=_no_pause)
    source: Stage = load_stage(use.uses)(context, **use.params)
    source.setup()
    try:
        return found[1].read_truth(_within(seconds, islice(source.process(), frames)), plan.room)
    finally:
        source.close()


def _scoring(plan: Plan) -> tuple[str, Scoring] | None:
    """The scorer of the room's truth, with its name."""
    use = plan.room.truth
    kind = None if use is None else ports(load_stage(use.uses)).outputs[0].type
    if kind is None:
        return None
    loaded = ((scorer.name, scorer.load()) for scorer in load_scorers())
    return next(((name, scoring) for name, scoring in loaded if issubclass(kind, scoring.truth)), None)


def _no_pause(_seconds: float) -> bool:
    """`Context.pause` that does not wait."""
    return True


def _within(seconds: float, messages: Iterable[T]) -> Iterator[T]:
    """The messages. Raises FollowspotError if they take longer than `seconds`."""
    deadline = time.monotonic() + seconds
    for read, message in enumerate(messages):
        if time.monotonic() > deadline:
            raise FollowspotError(f"the truth of {read} frames took {seconds:g} s, and more were to come")
        yield message
