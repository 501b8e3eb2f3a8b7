"""Errors of each fusion in situations that are hard for it: balls that are fast, side by side, or covered.

    python tools/bench/balls/situations.py recordings/dev1.yaml recordings/dev2.yaml
    python tools/bench/balls/situations.py graphs/rooms/simulated.yaml --frames 600 --json

The tracker runs once in each room with each fusion, and its tracks are compared with ground truth in all
frames in which a target is trackable. `fast`: the ball moves at more than 2 m/s, as in a toss; `beside`: the
centre of another ball is nearer than 25 cm; `handover`: of these the frames in which the two move relative to
each other at more than 0.2 m/s, as when balls change hands, for the truth knows no hands; `covered`: less
than half of the ball is visible to all colour or to all infrared cameras, as in a hand. For each: frames,
those without a position within 15 cm, RMSE and the RMSE of the worst target with five such frames or more,
outliers included, in mm.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

import followspot as fs
from bench.balls.motion_models import truths
from followspot import room_file
from followspot.messages import Array
from followspot.tables.terminal import table
from followspot_accuracy import TrackTable, TruthTable, read_tracks_csv, truth_of
from followspot_accuracy.targets.scoring import REACH, trajectory
from scripting import options_of

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
FUSIONS = ("balls.mean_shift", "balls.bundle")
SITUATIONS = ("all", "fast", "beside", "handover", "covered")
FAST = 2.0
"""m/s."""
BESIDE = 0.25
"""m, between the centres."""
PASSING = 0.2
"""m/s, of one ball relative to the other."""
FEWEST = 5
"""Frames of a target from which it may be the worst."""

Errors = dict[str, list[tuple[str, Array]]]
"""Of each situation the targets by name and their errors, m, NaN in a frame without a position."""


@dataclass(frozen=True)
class Figures:
    """A fusion in one situation; an RMSE is None if there is nothing to measure."""

    frames: int
    missed: int
    rmse_mm: float | None
    worst_mm: float | None
    worst: str


def main() -> None:
    """Measure and print a table."""
    parser = options_of(__doc__)
    parser.add_argument("rooms", type=Path, nargs="+", help="with ground truth")
    parser.add_argument("--graph", type=Path, default=GRAPH, help="(default: the demo's)")
    parser.add_argument("--frames", type=int, help="of each room")
    parser.add_argument(
        "--set", action="append", default=[], metavar="STAGE.KEY=VALUE", help="of the tracker"
    )
    args = parser.parse_args()
    settings = dict(one.split("=", 1) for one in args.set)
    found = {fusion: measure(args.rooms, args.graph, args.frames, settings, fusion) for fusion in FUSIONS}
    if args.json:
        print(json.dumps({f: {s: asdict(one) for s, one in of.items()} for f, of in found.items()}))
        return
    heads = ["fusion", "situation", "frames", "missed", "RMSE mm", "worst target mm", ""]
    rows = [[fusion, name, *cells(one)] for fusion, of in found.items() for name, one in of.items()]
    print(table(heads, rows))


def cells(one: Figures) -> list[str]:
    """The figures as text, in the order of the heads."""
    errors = ("-" if value is None else f"{value:.1f}" for value in (one.rmse_mm, one.worst_mm))
    return [str(one.frames), str(one.missed), *errors, one.worst]


def measure(
    rooms: Sequence[Path], graph: Path, frames: int | None, settings: Mapping[str, str], fusion: str
) -> dict[str, Figures]:
    """The figures of a fusion in each situation, over all rooms."""
    errors: Errors = defaultdict(list)
    for path in rooms:
        tracks, count = tracked(graph, path, frames, {"fuse.uses": fusion, **settings})
        truth = truth_of(truths(room_file.load(path), count))
        for situation, name, error in errors_of(tracks, truth):
            errors[situation].append((f"{path.stem} {name}", error))
    return {situation: figures(errors[situation]) for situation in SITUATIONS}


def tracked(
    graph: Path, room: Path, frames: int | None, settings: Mapping[str, str]
) -> tuple[TrackTable, int]:
    """The tracks of a run, and how many frames it had."""
    with tempfile.TemporaryDirectory() as out:
        with fs.run(graph, room=room, frames=frames, set=settings, out=out) as run:
            report = run.wait()
        return read_tracks_csv(Path(out) / "tracks.csv"), report.frames


def errors_of(tracks: TrackTable, truth: TruthTable) -> Iterator[tuple[str, str, Array]]:
    """Each situation and target with its errors in those frames in which it is trackable, m."""
    for own, name in enumerate(truth.objects):
        error = np.linalg.norm(trajectory(tracks, name, truth.time).xyz - truth.xyz[:, own], axis=1)
        for situation, there in situations(truth, own).items():
            yield situation, name, error[there & truth.trackable[:, own]]


def situations(truth: TruthTable, own: int) -> dict[str, Array]:
    """The frames of each situation of an object of the truth, (F,) bool."""
    others = np.delete(truth.xyz, own, axis=1) - truth.xyz[:, own, None]
    near = np.linalg.norm(others, axis=2) < BESIDE
    passing = np.linalg.norm(rates(others, truth.time), axis=2) > PASSING
    return {
        "all": np.ones(len(near), bool),
        "fast": np.linalg.norm(rates(truth.xyz[:, own], truth.time), axis=1) > FAST,
        "beside": near.any(axis=1),
        "handover": (near & passing).any(axis=1),
        "covered": ~truth.pair[:, own],
    }


def rates(xyz: Array, time: Array) -> Array:
    """Velocities (F, ..., 3) m/s of places over F times, s; zero if there is one time alone."""
    return np.gradient(xyz, time, axis=0) if len(xyz) > 1 else np.zeros_like(xyz)


def figures(errors: Sequence[tuple[str, Array]]) -> Figures:
    """The figures of all targets in one situation."""
    every = np.concatenate([error for _, error in errors]) if errors else np.zeros(0)
    often = {name: rmse_mm(error) for name, error in errors if np.isfinite(error).sum() >= FEWEST}
    worst = max(often, key=lambda name: often[name] or 0.0, default="-")
    missed = int((~(every < REACH)).sum())
    return Figures(len(every), missed, rmse_mm(every), often.get(worst), worst)


def rmse_mm(error: Array) -> float | None:
    """Root of the mean squared error of the frames with a position, mm; None without any."""
    known = error[np.isfinite(error)]
    return float(1e3 * np.sqrt(np.square(known).mean())) if len(known) else None


if __name__ == "__main__":
    main()
