"""Scores the tracks and poses of a run against the ground truth that its room declares."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import TypeVar

import numpy as np

from followspot.accuracy import (
    PersonsScore,
    PoseTruthTable,
    TargetScore,
    TruthTable,
    pose_truth_of,
    read_poses_csv,
    read_tracks_csv,
    score,
    score_persons,
    truth_of,
)
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.messages import Array
from followspot.operator.scored import scored_file
from followspot.people import Poses, PoseTruth
from followspot.plugins.registry import load_stage
from followspot.ports import ports
from followspot.room import Room
from followspot.stage import Context
from followspot.tracking import Tracks

T = TypeVar("T")


def room_truth(
    plan: Plan, frames: int | None = None, seconds: float = math.inf
) -> TruthTable | PoseTruthTable | None:
    """The ground truth of the room's first `frames` frames, or of all; None if the room declares none.

    A source that normally waits between frames does not wait here. Raises the errors of the truth's source,
    and FollowspotError if reading takes longer than `seconds`.
    """
    use = plan.room.truth
    if use is None:
        return None
    stage = load_stage(use.uses)
    context = Context(name="truth", room=plan.room, seed=plan.seed, pause=_no_pause)
    source = stage(context, **use.params)
    source.setup()
    try:
        messages = _within(seconds, islice(source.process(), frames))
        if ports(stage).outputs[0].type is PoseTruth:
            return pose_truth_of(messages, viewpoint(plan.room))
        return truth_of(messages)
    finally:
        source.close()


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


def run_scores(plan: Plan, out: Path, frames: int, seconds: float = math.inf) -> dict[str, TargetScore]:
    """Scores of the tracks that a run wrote; empty if there is no truth or there are no tracks.

    Raises the errors of :func:`room_truth`.
    """
    file = scored_file(plan, Tracks)
    if file is None or not (out / file).exists():
        return {}
    truth = room_truth(plan, frames, seconds)
    return score(read_tracks_csv(out / file), truth, plan.room) if isinstance(truth, TruthTable) else {}


def run_person_scores(plan: Plan, out: Path, frames: int, seconds: float = math.inf) -> PersonsScore | None:
    """Scores of the poses that a run wrote; None if there is no truth or there are no poses.

    Raises the errors of :func:`room_truth`.
    """
    file = scored_file(plan, Poses)
    if file is None or not (out / file).exists():
        return None
    truth = room_truth(plan, frames, seconds)
    return poses_score(plan.room, out / file, truth) if isinstance(truth, PoseTruthTable) else None


def poses_score(room: Room, file: Path, truth: PoseTruthTable) -> PersonsScore:
    """Scores of the poses in a file. Raises InputError."""
    return score_persons(read_poses_csv(file, lambda name: room.cameras[name].center[:2]), truth)


def viewpoint(room: Room) -> Array:
    """Point that directions and distances are measured from, (2,) m: the only camera, or the origin."""
    places = [camera.center[:2] for camera in room.cameras.values()]
    return places[0] if len(places) == 1 else np.zeros(2)
