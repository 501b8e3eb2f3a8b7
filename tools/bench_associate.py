"""Sets of joints or boxes per second that `persons.associate` takes on one core, and its accuracy.

    python tools/bench_associate.py --people 15 --frames 100

Simulated cameras in the corners of a room find people with noise, gaps, false persons and out of step by half
a frame. Everything they find stays in memory; the clock is the CPU time of one thread.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from followspot import Array, Room
from followspot.context import Context
from followspot.messages import Header, Message, stamped
from followspot.people import BONES
from followspot.plugins.registry import load_stage
from followspot.room import Member
from followspot.room_file import load
from followspot_accuracy import PoseTable, pose_truth_of, score_persons
from followspot_accuracy.persons.parts import correct_parts
from followspot_sim.actor.landmarks import NAMES, landmarks
from followspot_sim.actor.scene import stage_of
from scripting import options_of

ROOM = Path(__file__).parent.parent / "graphs" / "rooms" / "simulated_crowd.yaml"
Set = dict[str, tuple[Message, ...]]
"""Messages of all cameras about one frame, by their kind."""
LATE = (0.0, 0.5, 0.25, 0.5)
"""Time of exposure of each camera, in frames after the first one's."""


def main() -> None:
    """Measure; print a line for joints and one for boxes, or JSON."""
    parser = options_of(__doc__)
    parser.add_argument("--people", type=int, default=15)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--fps", type=float, default=25.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--exchanged", type=float, default=0.0, help="share of pictures with sides exchanged")
    parser.add_argument("--cameras", type=int, choices=(2, 3, 4), default=4, help="the first so many")
    given = parser.parse_args()
    params = {"people": given.people, "frames": given.frames, "fps": given.fps, "seed": given.seed}
    room, sets, truth, joints = found(params, given.exchanged)
    sets = [{kind: messages[: given.cameras] for kind, messages in one.items()} for one in sets]
    figures = {kind: measured(room, sets, truth, kind, 0.25 / given.fps) for kind in ("points", "boxes")}
    figures["points"]["correct_parts"] = parts_of(room, sets, joints, 0.25 / given.fps)
    if given.json:
        print(json.dumps(figures))
        return
    for kind, one in figures.items():
        print(
            f"{kind}: {one['sets_per_s']:.0f} sets/s of {given.people} people, {given.cameras} cameras, "
            f"MOTA {one['mota']:.3f}, IDF1 {one['idf1']:.3f}, {one['switches']} switches, "
            f"mean distance {100 * one['mean_m']:.1f} cm"
            + (f", {100 * one['correct_parts']:.1f} % correct parts" if kind == "points" else "")
        )


def found(given: dict[str, Any], exchanged: float) -> tuple[Room, list[Set], Any, list[Array]]:
    """The room, what is found in each frame, the truth, and the true joints (P, 17, 3) m of each frame.

    given: of `sim.person_points` and of the truth; exchanged: share of the pictures with sides exchanged.
    """
    room, fps, frames = load(ROOM), given["fps"], given["frames"]
    each = {}
    for (name, camera), late in zip(room.cameras.items(), LATE, strict=True):
        assert camera.source is not None
        params = dict(camera.source.params) | given | {"exchange_share": exchanged}
        stage = load_stage(camera.source.uses)(
            Context(name, room, Member("cameras", name)), **params, late_by=late / fps
        )
        stage.setup()
        each[name] = list(stage.process())
    sets = [
        {
            kind: tuple(_at(getattr(outputs[frame], kind), frame, fps) for outputs in each.values())
            for kind in ("points", "boxes")
        }
        for frame in range(frames)
    ]
    assert room.truth is not None
    source = load_stage(room.truth.uses)(Context("truth", room), **(dict(room.truth.params) | given))
    source.setup()
    return room, sets, pose_truth_of(source.process()), joints_of(source, frames)


def joints_of(source: Any, frames: int) -> list[Array]:
    """The true joints of each frame, (P, 17, 3) m."""
    stage = stage_of(source.params)
    plays = [stage.play(frame) for frame in range(frames)]
    people = [zip(stage.cast, play.stances, play.surfaces, strict=True) for play in plays]
    return [np.array([landmarks(actor.body, stance, skin) for actor, stance, skin in one]) for one in people]


def parts_of(room: Room, sets: list[Set], joints: list[Array], delay: float) -> float:
    """Share of the true parts, head to ankles, that are correct."""
    stage = load_stage("persons.associate")(Context("associate", room), delay_sigma=delay)
    stage.setup()
    parts = [(NAMES.index(a), NAMES.index(b)) for a, b in BONES]
    shares = []
    for one, true in zip(sets, joints, strict=True):
        skeletons = stage.process(points=one["points"]).skeletons
        people, row = np.unique(skeletons.person, return_inverse=True)
        column = np.array([NAMES.index(name) for name in skeletons.labels])[skeletons.label]
        there = np.full((len(people), len(NAMES), 3), np.nan)
        there[row, column] = skeletons.xyz
        shares.append(correct_parts(there, true, parts).mean())
    return float(np.mean(shares))


def _at(message: Message, frame: int, fps: float) -> Message:
    return stamped(replace(message), Header("network", frame, round(frame * 1e9 / fps)))  # type: ignore[type-var]


def measured(room: Room, sets: list[Set], truth: Any, kind: str, delay: float) -> dict[str, Any]:
    """Sets per second of CPU time, and scores. delay: sigma of the times of exposure, s."""
    stage = load_stage("persons.associate")(Context("associate", room), delay_sigma=delay)
    stage.setup()
    began = time.thread_time()
    poses = [stage.process(**{kind: one[kind]}).poses for one in sets]
    seconds = time.thread_time() - began
    moment = [one[kind][0].header.time / 1e9 for one in sets]
    rows = np.concatenate(
        [np.column_stack([p.xy, p.height, p.heading, p.pan, p.tilt]).reshape(-1, 6) for p in poses]
    )
    numbers = np.concatenate([p.person for p in poses])
    times = np.repeat(moment, [len(p.person) for p in poses])
    score = score_persons(PoseTable(times, numbers, rows), truth).tracking
    return {
        "sets_per_s": len(sets) / seconds,
        "mota": score.mota,
        "idf1": score.idf1,
        "switches": score.switches,
        "mean_m": score.mean_m,
    }


if __name__ == "__main__":
    main()
