"""One variant run in one room, and what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.library.execute import (
    OnProgress,
    RunOptions,
    RunReport,
    run_plan,
    scored_file,
)
from followspot.messages import Array, Message
from followspot.people import Poses
from followspot.tracking import Tracks
from followspot_accuracy import (
    PersonsScore,
    PoseTruthTable,
    TargetScore,
    TrackTable,
    TruthTable,
    read_tracks_csv,
    score,
)
from followspot_accuracy.scorings import PosesScoring
from followspot_accuracy.targets.metrics import Recoveries, found_while_sought, jerk_cost
from followspot_accuracy.targets.scoring import REACH, trajectory
from followspot_compare.recorded import detection_errors, pair_counts, read_fused


@dataclass(frozen=True)
class TargetFigures:
    """The figures of one target. A figure is NaN if the graph did not record what it needs."""

    tracks: TargetScore
    true_jerk_cost: float
    """Jerk cost of the truth in the frames that have a track: what a perfect tracker has."""
    fused_mm: float
    """RMSE of what the fusion gave, before the filter."""
    fused_px: float
    """Mean reprojection error of that against the truth."""
    detection_px: float
    """Mean distance of the reprojected tracks from the detections: the paper's reprojection error."""
    detection_std_px: float
    recovery: Recoveries = Recoveries(0, 0, 0)
    """Counts of frames in which the target was sought."""
    pairs: tuple[float, float, float] = (np.nan, np.nan, np.nan)
    """Number of pairs in a frame with a track: mean, 5th and 95th percentile."""


@dataclass(frozen=True)
class Trial:
    """One variant in one room."""

    variant: str
    room: str
    frames: int
    seconds: float
    tracking_ms: float
    """Time per frame in all stages but sources and sinks, ms."""
    targets: Mapping[str, TargetFigures]
    iterations: tuple[int, ...]
    """How many positions took 0, 1, 2, ... steps; empty if the graph did not record them."""
    persons: PersonsScore | None = None
    """Scores of poses if the room's truth is of persons; there are no targets then."""


def run_trial(
    variant: str,
    room: str,
    plan: Plan,
    truth: TruthTable | PoseTruthTable,
    options: RunOptions,
    on_progress: OnProgress | None,
) -> Trial:
    """Run the plan and score it. Raises FollowspotError if the run fails, KeyboardInterrupt on Ctrl-C."""
    report = run_plan(plan, options, on_progress)
    if report.stopped:
        raise KeyboardInterrupt
    if not report.ok:
        reasons = "\n".join(report.errors) or "messages are unaccounted for"
        raise FollowspotError(f'variant "{variant}" failed in room {room}:\n{reasons}')
    measured = (variant, room, report.frames, report.seconds, tracking_ms(report))
    if isinstance(truth, PoseTruthTable):
        poses = _written(plan, Poses, options.out)
        return Trial(*measured, {}, (), PosesScoring().score(poses, truth, plan.room).persons)
    targets, iterations = _figures(plan, options.out, truth)
    return Trial(*measured, targets, tuple(iterations.tolist()))


def tracking_ms(report: RunReport) -> float:
    """Time per frame in the stages that have inputs and outputs, ms."""
    edges = report.plan.edges
    inner = {edge.to_stage for edge in edges} & {edge.from_stage for edge in edges}
    busy = sum(s.busy_ms for worker in report.workers for s in worker.stages if s.stage in inner)
    return busy / max(1, report.frames)


def _figures(plan: Plan, out: Path, truth: TruthTable) -> tuple[dict[str, TargetFigures], Array]:
    """Figures of each target of the truth or the tracks, and the histogram of iterations."""
    room, objects = plan.room, tuple(plan.room.targets)
    tracks = read_tracks_csv(_written(plan, Tracks, out))
    scores = score(tracks, truth, room)
    fused = read_fused(out, tracks, objects)
    before = score(fused.tracks, truth, room) if fused else {}
    pixels = detection_errors(out, tracks, objects, tuple(room.cameras.values()))
    counts, nothing = pair_counts(out, tracks, objects), np.zeros(0)
    figures = {
        name: TargetFigures(
            one,
            true_jerk_cost(tracks, truth, name),
            before[name].rmse_mm if name in before else np.nan,
            before[name].reprojection_px if name in before else np.nan,
            *_mean_and_std(pixels.get(name, nothing)),
            recovery_of(tracks, truth, name),
            _mean_and_percentiles(counts.get(name, nothing)),
        )
        for name, one in scores.items()
    }
    return figures, np.bincount(fused.iterations) if fused else nothing.astype(int)


def _written(plan: Plan, kind: type[Message], out: Path) -> Path:
    """The table of messages of a type that a run wrote. Raises FollowspotError."""
    file = scored_file(plan, kind)
    if file is None:
        raise FollowspotError(f"graph {plan.graph} writes no {kind.__name__}; it needs a stage sinks.csv")
    return out / file


def true_jerk_cost(tracks: TrackTable, truth: TruthTable, name: str) -> float:
    """Jerk cost (eq. 9-10 of Jin & Qian 2008) of the truth in frames with a track; NaN without truth."""
    if name not in truth.objects:
        return np.nan
    there = trajectory(tracks, name, truth.time).there
    return jerk_cost(np.where(there[:, None], truth.xyz[:, truth.objects.index(name)], np.nan))


def recovery_of(tracks: TrackTable, truth: TruthTable, name: str) -> Recoveries:
    """Recoveries of a target; every one of a target that the truth does not know is false."""
    track = trajectory(tracks, name, truth.time)
    right = np.zeros(len(truth.time), bool)
    if name in truth.objects:
        right = np.linalg.norm(track.xyz - truth.xyz[:, truth.objects.index(name)], axis=1) < REACH
    return found_while_sought(track.there, right)


def _mean_and_percentiles(values: Array) -> tuple[float, float, float]:
    if not len(values):
        return np.nan, np.nan, np.nan
    low, high = np.percentile(values, [5, 95])
    return float(values.mean()), float(low), float(high)


def _mean_and_std(values: Array) -> tuple[float, float]:
    return (float(values.mean()), float(values.std())) if len(values) else (np.nan, np.nan)
