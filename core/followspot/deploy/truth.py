"""What the tracks of a run are measured against: the ground truth that its room declares."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

from followspot.accuracy import TargetScore, TruthTable, read_tracks_csv, score, truth_of
from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.stage import Context

TRACKS = "tracks.csv"
"""The tracks within a run's output folder, by the default of `sinks.csv`."""


def room_truth(plan: Plan, frames: int | None = None) -> TruthTable | None:
    """The truth of the room's first frames, or all; None where the room knows none.

    Raises what the truth's source raises where it cannot be read.
    """
    use = plan.room.truth
    if use is None:
        return None
    source = load_stage(use.uses)(Context(name="truth", room=plan.room, seed=plan.seed), **use.params)
    source.setup()
    try:
        return truth_of(islice(source.process(), frames))
    finally:
        source.close()


def run_scores(plan: Plan, out: Path, frames: int) -> dict[str, TargetScore]:
    """Scores of the tracks in a run's output folder; empty where there is no truth or there are no tracks."""
    if not (out / TRACKS).exists():
        return {}
    truth = room_truth(plan, frames)
    return {} if truth is None else score(read_tracks_csv(out / TRACKS), truth, plan.room)
