"""Accuracy of `persons.associate` with boxes of people who hide each other, walk, jump and fall.

    python tools/bench/persons/box_crowds.py --people 3 7 10 15 --seeds 1 2 3 4
    python tools/bench/persons/box_crowds.py --people 7 --acts jump fall
    python tools/bench/persons/box_crowds.py --people 3 --cameras 2

Four simulated cameras in the corners of a room see people on 4 x 3 m of floor, out of step by up to half a
frame. A row is the mean over the seeds; each seed has people, ways and errors of its own.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from statistics import mean

import numpy as np

from benching.box_people import moved, people, surfaces
from benching.box_pictures import network
from followspot import Array
from followspot.context import Context
from followspot.messages import Header, at, stamped
from followspot.people import Boxes, PoseTruth
from followspot.plugins.registry import load_stage
from followspot.room_file import load
from followspot.tables.terminal import table
from followspot_accuracy import PoseTable, pose_truth_of, score_persons
from scripting import options_of

ROOM = Path(__file__).parents[3] / "graphs/rooms/simulated_crowd.yaml"
LATE = (0.1, -0.4, -0.2, 0.5)
"""Time of exposure of each camera, in frames after the time stamp."""
STEPS = 20
"""Steps of the people in a frame."""
LYING = 0.8
"""Angle from upright beyond which a body lies, rad."""


def main() -> None:
    """Measure; print a row for each number of people."""
    parser = options_of(__doc__)
    parser.add_argument("--people", type=int, nargs="+", default=[3, 7, 10, 15])
    parser.add_argument("--acts", nargs="*", choices=("jump", "fall"), default=[], help="beside walking")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4])
    parser.add_argument("--frames", type=int, default=160)
    parser.add_argument("--fps", type=float, default=4.0)
    parser.add_argument("--false", type=float, default=0.3, help="mean number of false boxes in a picture")
    parser.add_argument("--cameras", type=int, choices=(2, 3, 4), default=4, help="the first so many")
    given = parser.parse_args()
    figures = {}
    for count in given.people:
        scores = [
            scored([boxes[: given.cameras] for boxes in sets], truth, given.fps)
            for sets, truth in (
                filmed(count, given.acts, seed, given.frames, given.fps, given.false) for seed in given.seeds
            )
        ]
        figures[count] = {name: mean(score[name] for score in scores) for name in scores[0]}
    if given.json:
        print(json.dumps(figures))
        return
    rows = [
        (
            f"{count}",
            f"{one['mota']:.3f}",
            f"{one['idf1']:.3f}",
            f"{one['new_numbers']:.1f}",
            f"{one['missed']:.1%}",
            f"{one['false']:.1%}",
            f"{100 * one['mean_m']:.1f} cm",
        )
        for count, one in figures.items()
    ]
    print(table(("people", "MOTA", "IDF1", "new numbers", "missed", "false", "distance"), rows))


def filmed(
    count: int, acts: Sequence[str], seed: int, frames: int, fps: float, false: float
) -> tuple[list[tuple[Boxes, ...]], list[PoseTruth]]:
    """The boxes of all cameras of each frame, and where the people are."""
    rng = np.random.default_rng([seed, count])
    networks = [network(camera, count, false, rng) for camera in load(ROOM).cameras.values()]
    late = [round(share * STEPS) for share in LATE]
    crowd = people(count, rng)
    pictures: list[list[Boxes]] = [[] for _ in networks]
    truth: list[PoseTruth] = []
    first = -min(late)
    for step in range(first + (frames - 1) * STEPS + max(late) + 1):
        here = np.flatnonzero(crowd.present)
        surface = surfaces(crowd)[here]
        for one, delay, shown_so_far in zip(networks, late, pictures, strict=True):
            frame, exact = divmod(step - first - delay, STEPS)
            if not exact and 0 <= frame < frames:
                seen = replace(one, bias=one.bias[here])
                boxes = seen.boxes(surface, crowd.tilt[here] > LYING, rng)
                shown_so_far.append(stamped(boxes, Header("network", frame, round(frame * 1e9 / fps))))
        frame, exact = divmod(step - first, STEPS)
        if not exact and 0 <= frame < frames:
            truth.append(at(round(frame * 1e9 / fps), placed(here, surface)))
        crowd = moved(crowd, 1 / fps / STEPS, acts, rng)
    return list(zip(*pictures, strict=True)), truth


def placed(person: Array, surface: Array) -> PoseTruth:
    """The places of people, in the middle of their bodies."""
    middle = (surface.min(axis=1) + surface.max(axis=1)) / 2
    zero = np.zeros(len(person))
    return PoseTruth(
        person=person.astype(np.int32),
        xy=middle[:, :2],
        height=surface[..., 2].max(axis=1),
        heading=zero,
        pan=zero,
        tilt=zero,
        visible=zero + 1.0,
    )


def scored(sets: Sequence[tuple[Boxes, ...]], truth: Sequence[PoseTruth], fps: float) -> dict[str, float]:
    """The figures of one recording."""
    stage = load_stage("persons.associate")(Context("associate", load(ROOM)), delay_sigma=0.25 / fps)
    stage.setup()
    poses = [stage.process(boxes=boxes).poses for boxes in sets]
    rows = [np.column_stack([p.xy, p.height, p.heading, p.pan, p.tilt]) for p in poses]
    times = np.repeat([boxes[0].header.time / 1e9 for boxes in sets], [len(p.person) for p in poses])
    found_poses = PoseTable(times, np.concatenate([p.person for p in poses]), np.concatenate(rows))
    found = score_persons(found_poses, pose_truth_of(truth)).tracking
    return {
        "mota": found.mota,
        "idf1": found.idf1,
        "new_numbers": found.switches,
        "missed": found.missed / found.truths,
        "false": found.false / found.truths,
        "mean_m": found.mean_m,
    }


if __name__ == "__main__":
    main()
