"""Whether balls that people half cover are tracked in random rooms, with each fusion.

    python tools/bench/balls/covered_rooms.py --rooms 12 --first 20000 --frames 300 -o runs/covered

Each room has its own cameras, targets, people and light, as in `random_rooms.py`, but people hold the balls
under an arm, against belly, chest or back, or low at the side, for seconds, and wear braces, cuffs and bands
that reflect, and patches in the colours of the balls; they also toss balls and hand them over. For each
fusion, over all targets and frames in which they are trackable: the share with a position within 15 cm, the
share reported beyond it, the share of errors within the ellipsoid of 95 %, NEES over 3 (`copies.py`), and
identity switches; then the same of the frames in which no colour or no infrared camera sees half of the ball
(`half covered`), and the worst targets. rooms.jsonl has the figures of all targets; the same command goes on
if it was interrupted.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from bench.balls.motion_models import truths
from bench.balls.random_rooms import templates_learnt
from bench.balls.situations import FUSIONS, GRAPH, tracked
from benching.random_rooms import random_room
from followspot import room_file
from followspot.messages import Array
from followspot.tables.terminal import table
from followspot_accuracy import TrackTable, TruthTable, truth_of
from followspot_accuracy.targets.metrics import within_ellipsoid
from followspot_accuracy.targets.scoring import REACH, trajectory
from scripting import options_of

SITUATIONS = ("all", "half covered")


@dataclass(frozen=True)
class Counted:
    """Frames of a target of one room in one situation.

    frames: trackable; within, beyond: of them with a position at most 15 cm off, and farther; rated: with a
    stated error; inside: of these within the ellipsoid of 95 %; nees: the sum of their NEES over 3.
    """

    room: int
    fusion: str
    target: str
    situation: str
    frames: int
    within: int
    beyond: int
    rated: int
    inside: int
    nees: float
    switches: int


def main() -> None:
    """Measure the rooms that the file lacks, then print the tables."""
    parser = options_of(__doc__)
    parser.add_argument("--rooms", type=int, default=12, help="number of seeds (default: %(default)s)")
    parser.add_argument("--first", type=int, default=20000, help="first seed (default: %(default)s)")
    parser.add_argument("--frames", type=int, default=300, help="of each room (default: %(default)s)")
    parser.add_argument("--graph", type=Path, default=GRAPH, help="(default: the demo's)")
    parser.add_argument("--set", action="append", default=[], metavar="STAGE.KEY=VALUE")
    parser.add_argument("--jobs", type=int, default=1, help="rooms at a time")
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for rooms.jsonl")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    file = args.out / "rooms.jsonl"
    lines = file.read_text().splitlines() if file.exists() else []
    known = [Counted(**json.loads(line)) for line in lines]
    seeds = range(args.first, args.first + args.rooms)
    missing = [seed for seed in seeds if seed not in {one.room for one in known}]
    settings = dict(text.split("=", 1) for text in args.set)
    with ProcessPoolExecutor(args.jobs) as pool, file.open("a") as out:
        work = [pool.submit(measured, seed, args.frames, args.graph, settings) for seed in missing]
        for number, one in enumerate(work, 1):
            found = one.result()
            out.writelines(json.dumps(asdict(counted)) + "\n" for counted in found)
            out.flush()
            known += found
            print(f"\r{number}/{len(work)} rooms", end="", file=sys.stderr, flush=True)
    known = [one for one in known if one.room in seeds]
    if args.json:
        print(json.dumps([asdict(one) for one in known]))
        return
    heads = ["fusion", "situation", "frames", "within 15 cm", "beyond", "ellipsoid", "NEES/3", "switches"]
    print(table(heads, list(summary(known))))
    print()
    print(table(["fusion", "worst targets", *heads[2:]], list(worst(known))))


def measured(seed: int, frames: int, graph: Path, settings: Mapping[str, str]) -> list[Counted]:
    """How the targets of a room are tracked with each fusion."""
    with TemporaryDirectory() as name:
        path = Path(name) / "room.yaml"
        room_file.save(random_room(seed, frames, covered=True), path)
        templates_learnt(path)
        truth = truth_of(truths(room_file.load(path), frames))
        return [
            one
            for fusion in FUSIONS
            for one in counted(
                tracked(graph, path, None, {"fuse.uses": fusion, **settings})[0], truth, seed, fusion
            )
        ]


def counted(tracks: TrackTable, truth: TruthTable, room: int, fusion: str) -> Iterator[Counted]:
    """The frames of each target in each situation."""
    for own, name in enumerate(truth.objects):
        track = trajectory(tracks, name, truth.time)
        off = track.xyz - truth.xyz[:, own]
        error = np.linalg.norm(off, axis=1)
        rated = np.isfinite(error) & np.isfinite(track.sigma).all(axis=1)
        taken = switches(track.xyz, truth, own)
        for situation, there in zip(SITUATIONS, (True, ~truth.pair[:, own]), strict=True):
            seen = truth.trackable[:, own] & there
            stated = seen & rated
            yield Counted(
                room,
                fusion,
                name,
                situation,
                int(seen.sum()),
                int((error[seen] < REACH).sum()),
                int((error[seen] >= REACH).sum()),
                int(stated.sum()),
                int(within_ellipsoid(off[stated], track.sigma[stated]).sum()),
                float(np.square(off[stated] / track.sigma[stated]).mean(axis=1).sum()),
                int((taken & there).sum()),
            )


def switches(xyz: Array, truth: TruthTable, own: int) -> Array:
    """Frames (F,) bool in which positions (F, 3) m go to another object: at it, and not at their own."""
    away = np.linalg.norm(truth.xyz - xyz[:, None], axis=2)
    others = (np.delete(away, own, axis=1) < REACH).any(axis=1)
    taken = others & ~(away[:, own] < REACH)
    return np.asarray(taken & ~np.concatenate([[False], taken[:-1]]))


def summary(found: Sequence[Counted]) -> Iterator[list[str]]:
    """A line for each fusion and situation, over all targets."""
    for fusion in FUSIONS:
        for situation in SITUATIONS:
            mine = [one for one in found if (one.fusion, one.situation) == (fusion, situation)]
            yield [fusion, situation, *cells(mine)]


def worst(found: Sequence[Counted], number: int = 8) -> Iterator[list[str]]:
    """A line for each target with most frames that are not within 15 cm, for each fusion."""
    for fusion in FUSIONS:
        mine = [one for one in found if one.fusion == fusion and one.situation == "all" and one.frames]
        for one in sorted(mine, key=lambda one: one.within - one.frames - one.beyond)[:number]:
            yield [fusion, f"{one.room} {one.target}", *cells([one])]


def cells(found: Sequence[Counted]) -> list[str]:
    """The figures as text, in the order of the heads."""
    frames, rated = sum(one.frames for one in found), sum(one.rated for one in found)
    within, beyond = sum(one.within for one in found), sum(one.beyond for one in found)
    inside, nees = sum(one.inside for one in found), sum(one.nees for one in found)
    shares = (
        f"{within / max(frames, 1):.2%}",
        f"{beyond / max(frames, 1):.2%}",
        f"{inside / max(rated, 1):.1%}",
    )
    return [str(frames), *shares, f"{nees / max(rated, 1):.2f}", str(sum(one.switches for one in found))]


if __name__ == "__main__":
    main()
