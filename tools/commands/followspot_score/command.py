"""`followspot score`: scores tracks of targets or poses of persons, as the header of the file says."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from followspot.csv_rows import header_of
from followspot.errors import InputError
from followspot.messages import Array
from followspot.room_file import load
from followspot_accuracy import (
    TrackTable,
    TruthTable,
    persons_table,
    persons_to_json,
    read_pose_truth_csv,
    read_poses_csv,
    read_tracks_csv,
    read_truth_csv,
    score,
    score_persons,
    table,
    to_json,
)
from followspot_accuracy.persons.tracking import Area
from followspot_accuracy.statistics import half_interval, nearest
from followspot_score.plot import draw
from followspot_score.trajectories import Span, draw_trajectories, within


def score_files(
    reported: Path,
    truth: Sequence[Path],
    room: Path | None,
    plots: Path | None,
    span: Span | None = None,
    area: Area | None = None,
    *,
    as_json: bool,
) -> str:
    """Scores as a table or as JSON. Raises InputError, FollowspotError.

    reported: tracks or poses; room: for tracks; plots: a folder for pictures; span: of the trajectories
    that are drawn, s; area: part of the floor that the truth of persons covers.
    """
    check_area(area)
    if "person" in header_of(reported):
        if span is not None:
            raise InputError.of(f"{reported} has poses of persons", "--between is for tracks of targets")
        return score_poses(reported, truth, plots, area, as_json=as_json)
    if area is not None:
        raise InputError.of(f"{reported} has tracks of targets", "--area is for poses of persons")
    if len(truth) > 1:
        text = f"{reported} has tracks of targets, which are scored against one file"
        raise InputError.of(text, "several files of truth are for poses of persons")
    check_span(span, plots)
    tracks, true = read_tracks_csv(reported), read_truth_csv(truth[0])
    _require_common(reported, truth[0], tracks, true)
    if span is not None and len(true.time) and not len(within(true, span).time):
        text = f"no frame of {truth[0]} is between {span[0]:g} and {span[1]:g} s"
        raise InputError.of(text, f"it has frames from {true.time[0]:g} to {true.time[-1]:g} s")
    scores = score(tracks, true, load(room) if room else None)
    drawn = draw_trajectories(tracks, true, plots, span) if plots is not None else ""
    if as_json:
        return json.dumps(to_json(scores))
    return table(scores) + (f"\n\n{drawn}" if drawn else "")


def check_span(span: Span | None, plots: Path | None) -> None:
    """Raises InputError unless a span of time goes from a time to a later one, and is drawn."""
    if span is not None and not -np.inf < span[0] < span[1] < np.inf:
        text = f"--between {span[0]:g} {span[1]:g} is no span of time"
        raise InputError.of(text, "give the first and the last second, for example --between 3.3 6.7")
    if span is not None and plots is None:
        raise InputError.of("--between chooses what is drawn, and nothing is", "add --plot DIR")


def check_area(area: Area | None) -> None:
    """Raises InputError unless an area goes from a corner to one beyond it on both axes."""
    if area is not None and not all(-np.inf < area[i] < area[i + 2] < np.inf for i in (0, 1)):
        text = f"--area {' '.join(f'{value:g}' for value in area)} is no area"
        raise InputError.of(text, "give the smallest x and y, then the largest, for example --area 2 0 6 3.4")


def score_poses(
    reported: Path, truth: Sequence[Path], plots: Path | None, area: Area | None, *, as_json: bool
) -> str:
    """Scores of poses. truth: the file of the camera that they are relative to; several for fused poses."""
    true = read_pose_truth_csv(*truth)

    def viewpoint(camera: str) -> Array:
        if len(truth) == 1:
            return true.viewpoint
        text = f"{reported} has poses relative to one camera {camera}".rstrip()
        raise InputError.of(text, "give the truth of that camera alone")

    poses = read_poses_csv(reported, viewpoint)
    scores = score_persons(poses, true, area)
    drawn = draw(poses, true, plots) if plots is not None else ""
    if as_json:
        return json.dumps(persons_to_json(scores))
    return persons_table(scores) + (f"\n\n{drawn}" if drawn else "")


def _require_common(reported: Path, truth: Path, tracks: TrackTable, true: TruthTable) -> None:
    """Raises InputError if tracks and truth have no target or no time in common: no figure would say that."""
    if not len(tracks.time) or not len(true.time):
        return
    named = {tracks.objects[number] for number in set(tracks.target.tolist())}
    if not named & set(true.objects):
        text = f"{reported} has {', '.join(sorted(named))}, {truth} has {', '.join(true.objects)}"
        raise InputError.of(text, "give the same targets the same names")
    if tracks.time.max() < true.time[0] or tracks.time.min() > true.time[-1]:
        spans = (f"{t.min():g} to {t.max():g} s" for t in (tracks.time, true.time))
        text = f"{reported} has {next(spans)}, {truth} {next(spans)}"
        raise InputError.of(text, "take both times from one clock")
    between = [name for name in true.objects if name in named and _between_frames(name, tracks, true)]
    if between:
        text = f"{truth} has {between[0]} at no time at which it has the other objects"
        raise InputError.of(text, "give all objects of a frame one time")


def _between_frames(name: str, tracks: TrackTable, true: TruthTable) -> bool:
    """Whether all rows of a target are nearest to frames without it, though some are near to its own."""
    own = np.isfinite(true.xyz[:, true.objects.index(name), 0])
    moments = tracks.time[tracks.target == tracks.objects.index(name)]
    if not own.any() or own.all():
        return False
    frame, _ = nearest(true.time, moments)
    _, apart = nearest(true.time[own], moments)
    return not own[frame].any() and bool((apart <= half_interval(true.time[own])).any())
