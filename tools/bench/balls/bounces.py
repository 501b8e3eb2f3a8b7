"""Bouncing balls: errors of a filter beside those of the triangulated points that it reads.

    python tools/bench/balls/bounces.py data/ball-trajectories-tt3d
    python tools/bench/balls/bounces.py FOLDER --filter filters.kalman_filterpy --set model=imm

The folder holds 3D_gt/NNN.csv, positions of real table-tennis balls at about 180 Hz, and VIEW/NNN.csv, where
virtual cameras see them at 25 Hz with 2 px of noise, of VIEW.yaml each. For every set of views: RMSE of the
points without filter, and of the filter's output where the points come without a covariance (as from mean
shift) and with it (as from `balls.bundle`); over all frames, and over those within two frames of a bounce.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from followspot import Camera, Context, Room, Target, at
from followspot.geometry import ray, triangulate_views
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.plugins.registry import load_stage
from followspot.tracking import Positions
from scripting import options_of

VIEWS = ("side", "oblique", "back")
NOISE = 2.0
"""Noise of the given image positions, one sigma along each axis, px."""
NEAR = 2.0
"""Frames from a bounce within which a frame counts as at it."""
STEEP = 0.5
"""Vertical speed before and after a bounce, m/s."""
MARGIN = 3
"""Samples at 180 Hz before and after a moment that this speed is taken over."""
NANOSECONDS = 1e9
OWN = "balls.kalman"


@dataclass(frozen=True, eq=False)
class Flight:
    """One trajectory: N frames at 25 Hz.

    time: (N,) s; truth: (N, 3) m; pixel: (N, V, 2) px; bounce: (N,) bool, within `NEAR` frames of one.
    """

    time: Array
    truth: Array
    pixel: Array
    bounce: Array


def camera_of(path: Path) -> Camera:
    """A virtual camera from its rotation vector, translation and focal length."""
    data = yaml.safe_load(path.read_text(encoding="utf-8"))
    rotation = cv2.Rodrigues(np.array(data["rvec"], float))[0]
    matrix = np.array([[data["f"], 0, data["w"] / 2], [0, data["f"], data["h"] / 2], [0, 0, 1]], float)
    size = (int(data["w"]), int(data["h"]))
    return Camera(path.stem, "color", size, matrix, np.zeros(5), rotation, np.array(data["tvec"], float))


def flights(folder: Path) -> Iterator[Flight]:
    """Every trajectory in the folder."""
    for path in sorted((folder / "3D_gt").glob("*.csv")):
        views = [_columns(folder / view / path.name, "Timestamp", "X", "Y", "Z", "u", "v") for view in VIEWS]
        time, frame = views[0][:, 0], np.median(np.diff(views[0][:, 0]))
        apart = np.abs(time[:, None] - bounces(_columns(path, "Timestamp", "Z")))
        pixel = np.stack([view[:, 4:] for view in views], axis=1)
        yield Flight(time, views[0][:, 1:4], pixel, apart.min(axis=1, initial=np.inf) <= NEAR * frame)


def bounces(height: Array) -> Array:
    """When a ball bounces off the table, s from the beginning: (N, 2) s and m, at 180 Hz -> (B,)."""
    time, z = height[:, 0] - height[0, 0], height[:, 1]
    inner = np.arange(MARGIN, len(z) - MARGIN)
    down = (z[inner] - z[inner - MARGIN]) / (time[inner] - time[inner - MARGIN])
    up = (z[inner + MARGIN] - z[inner]) / (time[inner + MARGIN] - time[inner])
    lowest = (z[inner] <= z[inner - 1]) & (z[inner] <= z[inner + 1])
    return np.asarray(time[inner[(down < -STEEP) & (up > STEEP) & lowest]])


def triangulated(cameras: Sequence[Camera], pixel: Array) -> tuple[Array, Array]:
    """Points (N, 3) m and their covariances (N, 3, 3) m^2 from (N, V, 2) px; equal errors in px."""
    centers = np.array([camera.center for camera in cameras])
    rays = np.stack([ray(camera, pixel[:, i]) for i, camera in enumerate(cameras)], axis=1)
    focal = np.array([camera.matrix[0, 0] for camera in cameras])
    points = triangulate_views(centers, rays, np.broadcast_to(1.0 / focal, rays.shape[:2]))
    weights = np.square(focal / np.linalg.norm(points[:, None] - centers, axis=2))
    points = triangulate_views(centers, rays, weights)
    across = np.eye(3) - rays[..., :, None] * rays[..., None, :]
    return points, np.linalg.inv((weights[..., None, None] * across).sum(axis=1)) * NOISE**2


def measured(xyz: Array, covariance: Array) -> Positions:
    """One place of the only target, (3,) m and (3, 3) m^2, that many agreeing candidates speak for."""
    shapes = {c.name: [1 if isinstance(size, str) else size for size in c.shape] for c in Positions.columns}
    row = {c.name: np.zeros(shapes[c.name], c.dtype) for c in Positions.columns}
    row |= {"xyz": xyz[None], "covariance": covariance[None]}
    return Positions(**row | {"support": np.full(1, 9, np.int32), "confirmed": np.ones(1, bool)})


def filtered(time: Array, points: Array, covariance: Array, uses: str = OWN, **params: float | str) -> Array:
    """Output of a filter for the points of one ball, (N, 3) m; uses: name of the stage."""
    room = Room(targets={"ball": Target("ball", 0.02)})
    stage = load_stage(uses)(Context(room=room), **params)
    stage.setup()
    found = []
    for moment, xyz, spread in zip(time, points, covariance, strict=True):
        message = measured(xyz, spread)
        outputs = stage.process(seal(at(round(moment * NANOSECONDS), message)))
        found.append(outputs.tracks.xyz[0])
    return np.array(found)


Figures = dict[str, dict[str, float]]
"""RMSE, mm: by "all frames" and "at bounces", then by method."""


def measure(folder: Path, **params: float | str) -> dict[str, Figures]:
    """Figures of each set of views; params: of the filter, and its name (`uses`)."""
    cameras, all_flights = [camera_of(folder / f"{view}.yaml") for view in VIEWS], list(flights(folder))
    sets = [chosen for size in (3, 2) for chosen in combinations(range(len(VIEWS)), size)]
    return {
        "+".join(VIEWS[i] for i in chosen): _of_views(
            [cameras[i] for i in chosen], chosen, all_flights, params
        )
        for chosen in sets
    }


def _of_views(
    cameras: Sequence[Camera], chosen: Sequence[int], all_flights: Sequence[Flight], params: dict[str, Any]
) -> Figures:
    squares: dict[str, list[Array]] = {"no filter": [], "filter": [], "filter, covariance": []}
    for flight in all_flights:
        points, covariance = triangulated(cameras, flight.pixel[:, chosen])
        unknown = np.full_like(covariance, np.nan)
        for name, xyz in (
            ("no filter", points),
            ("filter", filtered(flight.time, points, unknown, **params)),
            ("filter, covariance", filtered(flight.time, points, covariance, **params)),
        ):
            squares[name].append(np.square(xyz - flight.truth).sum(axis=1))
    bounce = np.concatenate([flight.bounce for flight in all_flights])
    errors = {name: np.concatenate(each) for name, each in squares.items()}
    return {
        "all frames": {name: _rmse_mm(square) for name, square in errors.items()},
        "at bounces": {name: _rmse_mm(square[bounce]) for name, square in errors.items()},
    }


def _rmse_mm(square: Array) -> float:
    return float(1e3 * np.sqrt(square.mean()))


def _columns(path: Path, *names: str) -> Array:
    table = np.genfromtxt(path, delimiter=",", names=True)
    return np.column_stack([table[name] for name in names])


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def main() -> None:
    """Measure and print a table, RMSE in mm."""
    parser = options_of(__doc__)
    parser.add_argument("folder", type=Path, help="with 3D_gt, side, oblique, back")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of the filter")
    parser.add_argument("--filter", default=OWN, metavar="STAGE", help="by default balls.kalman")
    args = parser.parse_args()
    params = {key: _number(value) for key, value in (option.split("=") for option in args.set)}
    result = measure(args.folder, uses=args.filter, **params)
    if args.json:
        print(json.dumps(result))
        return
    for place in ("all frames", "at bounces"):
        rows = {views: figures[place] for views, figures in result.items()}
        names = list(next(iter(rows.values())))
        print(f"{'RMSE, mm, ' + place:<22}" + "".join(f"{name:>20}" for name in names))
        for views, row in rows.items():
            print(f"{views:<22}" + "".join(f"{row[name]:>20.1f}" for name in names))


if __name__ == "__main__":
    main()
