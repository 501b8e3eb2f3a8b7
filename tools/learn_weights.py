"""Alpha and gamma of eq. 7 of Weinrich et al. 2010, and the power of it, learnt from poses that are known.

    python tools/learn_weights.py --room d_o.yaml --room d_p.yaml --frames 120

The first camera of each room plays a recording with truth. The slow instance works on it; then the cues of
the true pose are compared with those of poses around it, which a tracker might take instead. The weights are
those that make the truth most likely among them, by a search along one weight after the other. Half of the
pictures, every second ten, is held out: the gain on them is what the weights are worth.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
from collections.abc import Iterator
from contextlib import chdir
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benching.person_stages import build_stage, shots_with_people, with_header_of
from followspot import Array, Room
from followspot.frame_times import NANOSECOND
from followspot.people import Appearances
from followspot.room_file import load
from followspot_accuracy.scorings import PosesScoring
from followspot_persons.body.view import view
from followspot_persons.likelihood.combination import gamma_operation
from followspot_persons.likelihood.fitness import Fitness, pictured
from followspot_persons.pose_tracker import PoseTracker
from scripting import options_of

CUES = ("edge", "color", "difference")
SPREAD = np.array([0.2, 0.2, 0.05, 0.8, 0.5, 0.15])
"""One sigma of the poses around the true one: m, m, m, rad, rad, rad."""
RIVALS = 200
"""Number of these poses in a picture."""
BLOCK = 10
"""Pictures in a row that are all learnt from, or all held out."""
FACTORS = (0.25, 0.5, 0.8, 1.25, 2.0, 4.0)
"""Tried changes of a weight."""
NEAR = 0.5
"""Largest distance of a known person from the true one, m."""


def main() -> None:
    """Learn; print the weights and what they are worth."""
    parser = options_of(__doc__)
    parser.add_argument("--room", action="append", required=True, help="room file with truth; repeatable")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--every", type=int, default=4, help="frames between two of the slow instance")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    rng = np.random.default_rng(given.seed)
    cues = np.array([c for file in given.room for c in learning(file, given.frames, given.every, rng)])
    if len(cues) < 2 * BLOCK:
        raise SystemExit(f"only {len(cues)} pictures have a known person: give more --frames, or other rooms")
    figures = learnt(cues)
    if given.json:
        print(json.dumps(figures))
        return
    settings = " ".join(f"--set pose.{key}={value:.3g}" for key, value in figures["params"].items())
    print(
        f"{settings}\nlog-likelihood of the truth in {figures['held_out']} pictures that were held out: ",
        end="",
    )
    print(f"{figures['before']:.3f} before, {figures['after']:.3f} after")


def learning(file: str, frames: int, every: int, rng: np.random.Generator) -> list[Array]:
    """Cues of the pictures of a room file, whose recordings are named from its folder."""
    with chdir(Path(file).resolve().parent):
        return list(measured(load(Path(file).name), frames, every, rng))


def measured(room: Room, frames: int, every: int, rng: np.random.Generator) -> Iterator[Array]:
    """Cues of the true pose and of its rivals, (1 + RIVALS, CUES), for each picture of a known person."""
    assert room.truth is not None, "the room has no truth"
    told = build_stage(room.truth.uses, room, **room.truth.params).process()
    truth = PosesScoring().read_truth(told, room)
    tracker, gradients = build_stage("persons.pose_tracker", room), build_stage("persons.gradients", room)
    assert isinstance(tracker, PoseTracker)
    cues = tracker.cues
    for shot in shots_with_people(room, frames, every):
        edges = with_header_of(shot.frame, gradients.process(shot.frame))
        row = int(np.abs(truth.time - shot.frame.header.time * NANOSECOND).argmin())
        for pose in truth.pose[row][truth.visible[row] > 0.8]:
            known = _nearest(shot.people, pose)
            if known is None:
                continue
            picture = pictured(tracker.camera, shot.frame, edges)
            colors = known.mean[0].astype(np.float32), known.variance[0].astype(np.float32)
            fitness = Fitness(picture, cues.shape, cues.weights, colors=colors, pairs=cues.pairs)
            rivals = pose + SPREAD * rng.standard_normal((RIVALS, 6))
            seen = view(tracker.camera, tracker.shape, np.concatenate([pose[None], rivals]))
            yield np.column_stack([getattr(fitness, cue)(seen) for cue in CUES])


def _nearest(people: Appearances | None, pose: Array) -> Appearances | None:
    """What is known of the person at the true place alone."""
    if people is None or not len(people.person):
        return None
    away = np.hypot(*(people.pose[:, :2] - pose[:2]).T)
    row = [int(away.argmin())]
    found = replace(people, mean=people.mean[row], variance=people.variance[row])
    return found if away.min() < NEAR else None


def learnt(cues: Array) -> dict[str, Any]:
    """The weights, as parameters of `persons.pose_tracker`. cues: (pictures, poses, CUES), truth first."""
    own = np.arange(len(cues)) // BLOCK % 2 == 0
    start = np.array([1.0, 1.0, 1.0, 0.8, 40.0])
    best = _searched(cues[own], start)
    shipped = np.array([1.0, 1.0, 0.0, 0.8, 40.0])
    names = [f"{cue}_weight" for cue in CUES] + ["gamma", "likelihood_power"]
    return {
        "params": dict(zip(names, best.tolist(), strict=True)),
        "pictures": int(own.sum()),
        "held_out": int((~own).sum()),
        "before": _log_likelihood(cues[~own], shipped),
        "after": _log_likelihood(cues[~own], best),
    }


def _searched(cues: Array, start: Array) -> Array:
    """Weights, gamma and power of the highest log-likelihood; the weight of the edges is the unit."""
    best, value = start, _log_likelihood(cues, start)
    while True:
        tried = [t for i in range(1, len(start)) for t in _changed(best, i)]
        values = [_log_likelihood(cues, t) for t in tried]
        if max(values) <= value + 1e-6:
            return best
        best, value = tried[int(np.argmax(values))], max(values)


def _changed(weights: Array, index: int) -> Iterator[Array]:
    """The weights with one of them changed, within the limits of the parameters."""
    ends = {3: (0.0, 1.0), 4: (1.0, 1000.0)}
    low, high = ends.get(index, (0.01, 100.0))
    steps = [weights[index] + d for d in (-0.1, 0.1)] if index == 3 else [weights[index] * f for f in FACTORS]
    for value in np.clip(steps, low, high):
        changed = weights.copy()
        changed[index] = value
        yield changed


def _log_likelihood(cues: Array, weights: Array) -> float:
    """Mean log-probability of the true pose among its rivals."""
    counting = [i for i in range(len(CUES)) if weights[i] > 0]
    value = gamma_operation(
        [cues[..., i] for i in counting], [float(weights[i]) for i in counting], weights[3]
    )
    log = weights[4] * np.log(np.maximum(value, 1e-9))
    return float((log[:, 0] - np.logaddexp.reduce(log, axis=1)).mean())


if __name__ == "__main__":
    main()
