"""Motion models on recordings: errors of `balls.kalman` and of the models of `filters.kalman_filterpy`.

    python tools/bench/balls/motion_models.py recordings/dev1.yaml recordings/dev3.yaml \
        --set fuse.uses=balls.bundle

The tracker runs once in each room, and each filter gets the positions that its filter got. RMSE against
ground truth, mm, of the filter's positions and of its forecasts for the next frame: in all trackable frames,
in those of free flight (acceleration within 1.5 m/s^2 of gravity) and in those within two frames of a hit or
a bounce (above 40 m/s^2). Errors beyond half a metre are left out: no motion model makes them.
"""

from __future__ import annotations

import json
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import followspot as fs
from followspot import Context, Stage
from followspot.frame_times import NANOSECOND
from followspot.messages import Array
from followspot.plugins.registry import load_stage
from followspot.room_file import load
from followspot.tables.terminal import table
from followspot.tracking import LOST, Positions, Truth
from scripting import options_of

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
FILTERPY = "filters.kalman_filterpy"
FILTERS: dict[str, tuple[str, dict[str, str]]] = {"balls.kalman": ("balls.kalman", {})} | {
    model: (FILTERPY, {"model": model}) for model in ("constant_velocity", "constant_acceleration", "imm")
}
GRAVITY = np.array([0.0, 0.0, -9.81])
FLIGHT, HIT = 1.5, 40.0
"""m/s^2."""
BEYOND = 0.5
"""Errors beyond which a target was lost, m."""
KINDS = ("all", "flight", "hit")

Path3 = dict[int, dict[int, Array]]
"""Of each target its places by capture time, ns."""
Errors = dict[str, list[Array]]
"""Of each kind of frame the errors of each target, m."""


def main() -> None:
    """Measure and print a table."""
    parser = options_of(__doc__)
    parser.add_argument("rooms", type=Path, nargs="+", help="with ground truth")
    parser.add_argument("--frames", type=int, help="of each room")
    parser.add_argument(
        "--set", action="append", default=[], metavar="STAGE.KEY=VALUE", help="of the tracker"
    )
    args = parser.parse_args()
    result = measure(args.rooms, args.frames, dict(one.split("=", 1) for one in args.set))
    if args.json:
        print(json.dumps(result))
        return
    heads = ["filter", *[f"{what}, {kind}" for what in ("position", "forecast") for kind in KINDS]]
    rows = [[name, *(f"{value:.1f}" for value in figures)] for name, figures in result.items()]
    print(table(heads, rows))


def measure(rooms: Sequence[Path], frames: int | None, changes: dict[str, str]) -> dict[str, list[float]]:
    """RMSE, mm, of each filter: positions and forecasts, each by kind of frame; NaN without such frames."""
    found: dict[str, tuple[Errors, Errors]] = {
        name: (defaultdict(list), defaultdict(list)) for name in FILTERS
    }
    for path in rooms:
        room = load(path)
        given = recorded(path, frames, changes)
        truth = list(truths(room, len(given)))
        for name, (uses, params) in FILTERS.items():
            stage = load_stage(uses)(Context(room=room), **params)
            for places, errors in zip(filtered(stage, given), found[name], strict=True):
                add_errors(errors, places, truth, list(room.targets))
    return {
        name: [rmse_mm(errors[kind]) for errors in both for kind in KINDS] for name, both in found.items()
    }


def recorded(room: Path, frames: int | None, changes: dict[str, str]) -> list[Positions]:
    """The positions that the filter of the tracker gets in a room."""
    with (
        tempfile.TemporaryDirectory() as out,
        fs.run(GRAPH, room=room, frames=frames, set=changes, ports=["bridge.out"], out=out) as run,
    ):
        return list(run.subscribe("bridge.out", Positions))


def truths(room: fs.Room, frames: int) -> Iterator[Truth]:
    """The ground truth of the room's first frames. Raises FollowspotError if it has none."""
    if room.truth is None:
        raise fs.FollowspotError(f"{room.name} has no ground truth")
    source = load_stage(room.truth.uses)(Context(room=room, pause=lambda _: True), **room.truth.params)
    source.setup()
    yield from (truth for truth, _ in zip(source.process(), range(frames), strict=False))
    source.close()


def filtered(stage: Stage, given: Sequence[Positions]) -> tuple[Path3, Path3]:
    """Places of the targets, and where they were expected to be."""
    stage.setup()
    places: Path3 = defaultdict(dict)
    expected: Path3 = defaultdict(dict)
    for message, following in zip(given, [*given[1:], None], strict=True):
        outputs = stage.process(message)
        for target, xyz in zip(outputs.tracks.target, outputs.tracks.xyz, strict=True):
            places[int(target)][message.header.time] = xyz
        if following is not None:
            for target in np.flatnonzero(outputs.forecast.state != LOST):
                expected[int(target)][following.header.time] = outputs.forecast.xyz[target]
    return places, expected


def add_errors(errors: Errors, places: Path3, truth: Sequence[Truth], targets: Sequence[str]) -> None:
    """Add the errors of one room in each kind of frame."""
    time = np.array([one.header.time for one in truth])
    known = [number for number, name in enumerate(targets) if all(name in one.objects for one in truth)]
    for number in known:
        name = targets[number]
        rows = [one.objects.index(name) for one in truth]
        true = np.array([one.xyz[row] for one, row in zip(truth, rows, strict=True)])
        trackable = np.array([one.trackable[row] for one, row in zip(truth, rows, strict=True)])
        flight, hit = motions(time, true)
        there = np.full_like(true, np.nan)
        for moment, xyz in places[number].items():
            nearest = np.abs(time - moment).argmin()
            there[nearest] = xyz
        error = np.linalg.norm(there - true, axis=1)
        counted = trackable & (error < BEYOND)
        for kind, of_kind in zip(KINDS, (counted, counted & flight, counted & hit), strict=True):
            errors[kind].append(error[of_kind])


def motions(time: Array, xyz: Array) -> tuple[Array, Array]:
    """Frames of free flight, and those near a hit or a bounce, (N,) bool each; time: ns."""
    acceleration = np.zeros_like(xyz)
    period = np.median(np.diff(time)) * NANOSECOND
    acceleration[1:-1] = np.diff(xyz, n=2, axis=0) / period**2
    hit = np.convolve(np.linalg.norm(acceleration, axis=1) > HIT, np.ones(5), "same") > 0
    falling = np.linalg.norm(acceleration - GRAVITY, axis=1) < FLIGHT
    return falling & ~hit, hit


def rmse_mm(errors: Sequence[Any]) -> float:
    """RMSE of the errors of all targets, mm."""
    every = np.concatenate(errors)
    return float(1e3 * np.sqrt(np.square(every).mean())) if len(every) else float("nan")


if __name__ == "__main__":
    main()
