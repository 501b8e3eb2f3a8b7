"""What the tracks and poses of a run are measured against: the ground truth that its room declares."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

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
from followspot.graph.plan import Plan
from followspot.messages import Array
from followspot.people import PoseTruth
from followspot.plugins.registry import load_stage
from followspot.ports import ports
from followspot.room import Room
from followspot.stage import Context

TRACKS = "tracks.csv"
"""The tracks within a run's output folder, by the default of `sinks.csv`."""
POSES = "poses.csv"
"""The poses of persons, by the default of `sinks.csv_poses`."""


def room_truth(plan: Plan, frames: int | None = None) -> TruthTable | PoseTruthTable | None:
    """The truth of the room's first frames, or all; None where the room knows none.

    Raises what the truth's source raises where it cannot be read.
    """
    use = plan.room.truth
    if use is None:
        return None
    stage = load_stage(use.uses)
    source = stage(Context(name="truth", room=plan.room, seed=plan.seed), **use.params)
    source.setup()
    try:
        messages = islice(source.process(), frames)
        if ports(stage).outputs[0].type is PoseTruth:
            return pose_truth_of(messages, viewpoint(plan.room))
        return truth_of(messages)
    finally:
        source.close()


def run_scores(plan: Plan, out: Path, frames: int) -> dict[str, TargetScore]:
    """Scores of the tracks in a run's output folder; empty where there is no truth or there are no tracks."""
    if not (out / TRACKS).exists():
        return {}
    truth = room_truth(plan, frames)
    return score(read_tracks_csv(out / TRACKS), truth, plan.room) if isinstance(truth, TruthTable) else {}


def run_person_scores(plan: Plan, out: Path, frames: int) -> PersonsScore | None:
    """Scores of the poses in a run's output folder; None where there is no truth or there are no poses."""
    if not (out / POSES).exists():
        return None
    truth = room_truth(plan, frames)
    return poses_score(plan.room, out, truth) if isinstance(truth, PoseTruthTable) else None


def poses_score(room: Room, out: Path, truth: PoseTruthTable) -> PersonsScore:
    """Scores of the poses in a run's output folder. Raises InputError."""
    return score_persons(read_poses_csv(out / POSES, lambda name: room.cameras[name].center[:2]), truth)


def viewpoint(room: Room) -> Array:
    """From where directions and distances are told, (2,) m: the only camera, or the origin."""
    places = [camera.center[:2] for camera in room.cameras.values()]
    return places[0] if len(places) == 1 else np.zeros(2)
