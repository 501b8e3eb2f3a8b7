"""Poses and true poses of persons as arrays, from CSV files or messages.

Six numbers are a pose, in room quantities as in `followspot.people`: x, y, height (m), heading, pan,
tilt (rad). Files give headings relative to the camera; here they are in the room.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot.csv_rows import Row, header_of, read_rows
from followspot.errors import FollowspotError
from followspot.frame_times import to_seconds
from followspot.geometry import direction, wrap
from followspot.messages import Array
from followspot.people import PoseTruth
from followspot_accuracy.frame_rows import not_empty, one_at_a_time, one_in_a_frame
from followspot_accuracy.statistics import frames_of

POSE_COLUMNS = ("time", "person", "x", "y", "z_head_top", "torso_heading", "head_pan", "head_tilt")
PLACES = ("time", "person", "x", "y")
"""Columns of truth that tells places alone."""
TRUTH_COLUMNS = (*POSE_COLUMNS, "torso_heading_room", "r", "visible_upper")
CAMERA = "camera"
"""Optional column of poses: empty for fused ones, whose heading is in the room."""
NAMED = ("person", CAMERA)
"""Columns that, with the time, identify a pose of a file."""
MOST_CELLS = 5_000_000
"""Frames times persons."""
ORIGIN = np.zeros(2)

Viewpoint = Callable[[str], Array]
"""Name of a camera -> its place on the floor plan, (2,) m."""


@dataclass(frozen=True, eq=False)
class PoseTable:
    """Poses that a tracker reported: N rows in any order.

    time: (N,) s; person: (N,) numbers; pose: (N, 6).
    """

    time: Array
    person: Array
    pose: Array


@dataclass(frozen=True, eq=False)
class PoseTruthTable:
    """True poses of P persons at F ascending times.

    time: (F,) s; pose: (F, P, 6), NaN if a person is absent; visible: (F, P) visible share of the upper
    body, 0 if absent; viewpoint: (2,) m, the point to which directions and distances refer.
    """

    persons: tuple[int, ...]
    time: Array
    pose: Array
    visible: Array
    viewpoint: Array


def read_poses_csv(path: Path, viewpoint: Viewpoint) -> PoseTable:
    """Poses as `sinks.csv` writes them; more columns are ignored. Raises InputError.

    viewpoint: places of the cameras that headings are relative to.
    """
    columns = (*POSE_COLUMNS, CAMERA) if CAMERA in header_of(path) else POSE_COLUMNS
    time, person, pose = [], [], []
    for row in one_at_a_time(read_rows(path, columns), *(name for name in NAMED if name in columns)):
        values = np.array(row.numbers(*POSE_COLUMNS[2:]))
        camera = row.cell(CAMERA) if CAMERA in row.columns else None
        if camera != "":
            values[3] = wrap(values[3] + direction(viewpoint(camera or "") - values[:2]))
        time.append(row.number("time"))
        person.append(row.integer("person"))
        pose.append(values)
    return PoseTable(np.array(time, "f8"), np.array(person, "i8"), np.array(pose, "f8").reshape(-1, 6))


def read_pose_truth_csv(*paths: Path) -> PoseTruthTable:
    """True poses, of one camera or of several that see the same persons. Raises InputError.

    A person is as visible as in the camera that sees most of the person. The viewpoint is the camera's, of
    several the origin. A file may tell places alone (`PLACES`): the rest of a pose is NaN then, and the
    persons are in full view, as seen from the origin.
    """
    rows = not_empty((row for path in paths for row in _truth_rows(path)), *paths)
    places = [place for _, _, place in rows]
    viewpoint = np.median(places, axis=0) if len(paths) == 1 else ORIGIN
    return _truth_table([(time, found) for time, found, _ in rows], np.asarray(viewpoint))


def pose_truth_of(messages: Iterable[PoseTruth], viewpoint: Array = ORIGIN) -> PoseTruthTable:
    """True poses as a `room.truth` source gives them, one message per frame."""
    rows = [
        (to_seconds(m.header.time), (int(m.person[i]), pose, float(m.visible[i])))
        for m in messages
        for i, pose in enumerate(np.column_stack([m.xy, m.height, m.heading, m.pan, m.tilt]))
    ]
    return _truth_table(rows, viewpoint)


_Person = tuple[int, Array, float]
"""Number, pose and visible share."""


def _truth_rows(path: Path) -> Iterator[tuple[float, _Person, Array]]:
    if set(TRUTH_COLUMNS) & set(header_of(path)) - set(PLACES):
        yield from map(_truth_row, one_in_a_frame(read_rows(path, TRUTH_COLUMNS), "person"))
        return
    for row in one_in_a_frame(read_rows(path, PLACES), "person"):
        pose = np.full(6, np.nan)
        pose[:2] = row.numbers("x", "y")
        yield row.number("time"), (row.integer("person"), pose, 1.0), ORIGIN


def _truth_row(row: Row) -> tuple[float, _Person, Array]:
    """Time, person and the camera's position: at distance `r`, in the direction by which the two headings
    differ.
    """
    x, y, height, relative, pan, tilt, heading, r, visible = row.numbers(*TRUTH_COLUMNS[2:])
    toward = heading - relative
    place = np.array([x + r * np.cos(toward), y + r * np.sin(toward)])
    pose = np.array([x, y, height, heading, pan, tilt])
    return row.number("time"), (row.integer("person"), pose, visible), place


def _truth_table(rows: Sequence[tuple[float, _Person]], viewpoint: Array) -> PoseTruthTable:
    """Sort rows into frames by their time.

    Of the same frame and person the most visible pose counts, of equal ones the last, and one without a
    height only if there is no other.
    """
    persons = tuple(sorted({person for _, (person, _, _) in rows}))
    time, frame = frames_of(np.array([t for t, _ in rows], "f8"))
    if len(time) * len(persons) > MOST_CELLS:
        raise FollowspotError(f"{len(persons)} persons in {len(time)} frames are too many to compare")
    pose = np.full((len(time), len(persons), 6), np.nan)
    visible = np.zeros((len(time), len(persons)))
    columns = {person: i for i, person in enumerate(persons)}
    ranks = [(bool(np.isfinite(values[2])), share) for _, (_, values, share) in rows]
    for row in sorted(range(len(rows)), key=ranks.__getitem__):
        person, values, share = rows[row][1]
        cell = frame[row], columns[person]
        pose[cell], visible[cell] = values, max(visible[cell], share)
    return PoseTruthTable(persons, time, pose, visible, viewpoint)
