"""How people are tracked in situations that are hard: close by, behind a screen, in dim light, crossing.

    python tools/bench_strangers.py --kinds near screen --seeds 31 32 33

Each seed renders other people, clothes, ways and furniture. The detector looks at every third picture; what
it finds goes through slow and fast instance in memory. Prints a line for each seed, and medians and worst.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benching.person_stages import build_stage, build_used_stage, shots_with_people, with_header_of
from followspot import Array, Room
from followspot.frame_times import NANOSECOND
from followspot.people import Poses
from followspot.room_file import load
from followspot_accuracy.persons.matching import REACH, UNMATCHED, match
from followspot_accuracy.persons.scoring import PersonsScore, score_persons
from followspot_accuracy.persons.tables import PoseTable, PoseTruthTable
from followspot_accuracy.scorings import PosesScoring
from scripting import options_of

ROOMS = Path(__file__).parent.parent / "graphs" / "rooms"
NEAR = {"people": 1, "clear_radius": 0.75, "walking_area": [-1.5, -1.5, 1.2, 1.5]}
KINDS: Mapping[str, tuple[str, dict[str, Any]]] = {
    "panorama": ("simulated_panorama.yaml", {}),
    "near": ("simulated_panorama.yaml", NEAR),
    "screen": ("simulated_panorama.yaml", {"people": 1}),
    "dim": ("simulated_panorama.yaml", {"dimmed": [8.0, 16.0, 0.3]}),
    "crossing": ("simulated_persons.yaml", {}),
}
"""Room of each situation, and what is other in it."""
EVERY = 3
"""Pictures from one that the detector searches to the next."""
COLUMNS = (
    "coverage %",
    "position cm",
    "distance m",
    "height cm",
    "switches",
    "returns",
    "known",
    "false %",
    "longest s",
)
WORST: tuple[Callable[[Array], Any], ...] = (
    np.min,
    np.max,
    *[lambda column: column[np.abs(column).argmax()]] * 2,
    *[np.max] * 2,
    np.min,
    *[np.max] * 2,
)


def main() -> None:
    """Measure; print lines, or JSON."""
    parser = options_of(__doc__)
    parser.add_argument("--kinds", nargs="+", action="extend", choices=list(KINDS), help="none: all")
    parser.add_argument("--seeds", nargs="+", type=int, default=[31, 32, 33])
    parser.add_argument("--frames", type=int, default=150)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    figures = {
        kind: [figures_of(*tracked(room_of(kind, seed, given.frames), given.frames)) for seed in given.seeds]
        for kind in given.kinds or KINDS
    }
    if given.json:
        print(
            json.dumps(
                {kind: [dict(zip(COLUMNS, f, strict=True)) for f in figures[kind]] for kind in figures}
            )
        )
        return
    print("situation  seed    " + "".join(f"{name:>13}" for name in COLUMNS))
    for kind, rows in figures.items():
        for seed, row in zip(given.seeds, rows, strict=True):
            print(line(kind, seed, row))
        columns = np.array(rows).T
        print(line(kind, "median", [float(np.median(c)) for c in columns]))
        print(line(kind, "worst", [float(w(c)) for w, c in zip(WORST, columns, strict=True)]))


def room_of(kind: str, seed: int, frames: int) -> Room:
    """The first camera of a situation's room, with the people of a seed."""
    file, other = KINDS[kind]
    room = load(ROOMS / file)
    camera = next(iter(room.cameras.values()))
    assert camera.source is not None
    assert room.truth is not None
    changed = {**other, "seed": seed, "frames": frames}
    source = replace(camera.source, params={**camera.source.params, **changed})
    truth = replace(room.truth, params={**room.truth.params, **changed})
    return replace(room, cameras={camera.name: replace(camera, source=source)}, truth=truth)


def tracked(room: Room, frames: int) -> tuple[PersonsScore, float]:
    """The score of slow and fast instance, and how long the longest false person lasted, s."""
    assert room.truth is not None
    truth = PosesScoring().read_truth(build_used_stage(room.truth, room).process(), room)
    gradients, tracker = build_stage("persons.gradients", room), build_stage("persons.pose_tracker", room)
    found = []
    for shot in shots_with_people(room, frames, EVERY):
        edges = with_header_of(shot.frame, gradients.process(shot.frame))
        poses = with_header_of(shot.frame, tracker.process(shot.frame, edges, shot.people, shot.boxes))
        found.append(poses)
    poses = table_of(found)
    return score_persons(poses, truth), longest_false(poses, truth)


def longest_false(poses: PoseTable, truth: PoseTruthTable) -> float:
    """Longest time in which a number had a pose in each frame, farther than `REACH` from everybody, s."""
    matches, period, longest = match(poses, truth), float(np.median(np.diff(truth.time))), 0.0
    for person in np.unique(poses.person):
        own = poses.person == person
        false = (matches.frame[own] != UNMATCHED) & (matches.apart[own] > REACH)
        ends = np.diff(false) | (np.diff(poses.time[own]) > 1.5 * period)
        for run in np.split(np.arange(len(false)), np.flatnonzero(ends) + 1):
            if len(run) and false[run[0]]:
                longest = max(longest, float(np.ptp(poses.time[own][run])) + period)
    return longest


def table_of(poses: Sequence[Poses]) -> PoseTable:
    """Messages as a table."""
    rows = [np.column_stack([p.xy, p.height, p.heading, p.pan, p.tilt]) for p in poses]
    return PoseTable(
        np.concatenate([np.full(len(p.person), p.header.time * NANOSECOND) for p in poses]),
        np.concatenate([p.person for p in poses]),
        np.concatenate(rows),
    )


def figures_of(score: PersonsScore, longest: float) -> list[float]:
    """The figures of `COLUMNS`."""
    one = score.overall
    return [
        100 * one.coverage,
        one.position_cm.median,
        one.distance_m.mean,
        one.height_cm.mean,
        one.identity_switches,
        one.returns,
        one.returns_known,
        100 * score.surplus.false_share,
        longest,
    ]


def line(kind: str, name: object, row: Sequence[float]) -> str:
    """A line of the table."""
    return f"{kind:<11}{name!s:<8}" + "".join(f"{value:13.2f}" for value in row)


if __name__ == "__main__":
    main()
