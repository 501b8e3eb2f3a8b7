"""Make the README's moving picture from a run's own output: camera tiles with tracks, and the floor plan.

    python tools/record_demo.py --room ROOM.yaml --tracks tracks.csv -o docs/demo.webp

The pictures come from the sources that the room file declares, the rings and trails from the tracks that
the run saved. The suffix of the output chooses WebP (small), GIF or PNG.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from followspot import Camera, Context, Room
from followspot.accuracy import TrackTable, read_tracks_csv
from followspot.accuracy.statistics import nearest
from followspot.geometry import project
from followspot.messages import Array
from followspot.plugins.registry import load_stage
from followspot.room_file import load

TILE = (240, 180)
"""Size of a camera's picture, px."""
GAP = 4
"""Between tiles, px."""
PAPER, GRID, INK = (24, 22, 20), (52, 48, 45), (225, 225, 225)
"""Background, lines and text, BGR."""
TRAIL = 25
"""Pictures of the past in the floor plan."""
OLDEST = 0.6
"""Lowest opacity of a trail; WebP would not erase fainter ones."""
GAIN = 1.6
"""Brightness of the tiles over that of the pictures, which are dark."""
SAME_TIME = 0.004
"""Largest difference between a track and a picture, s."""
FONT = cv2.FONT_HERSHEY_SIMPLEX


Color = tuple[int, int, int]
"""BGR"""


def main() -> None:
    """Read the room and the tracks, draw every n-th frame, write the animation."""
    args = arguments()
    room = load(args.room)
    streams = [pictures(room, camera, args.first, args.last, args.step) for camera in room.cameras.values()]
    moments = list(zip(*streams, strict=False))
    time = np.array([views[0][0] for views in moments])
    xyz = positions(read_tracks_csv(args.tracks), room, time)
    plan = FloorPlan(room, xyz, target_colors(room))
    movie = cv2.Animation()
    movie.frames = [compose([image for _, image in views], i, plan) for i, views in enumerate(moments)]
    movie.durations = [args.pause] * len(movie.frames)
    args.output.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwriteanimation(str(args.output), movie, [cv2.IMWRITE_WEBP_QUALITY, args.quality])
    print(f"{args.output}: {len(movie.frames)} pictures, {args.output.stat().st_size / 1e6:.2f} MB")


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--room", type=Path, required=True)
    parser.add_argument("--tracks", type=Path, required=True, help="saved by sinks.csv")
    parser.add_argument("-o", "--output", type=Path, required=True, help=".webp, .gif or .png")
    parser.add_argument("--first", type=int, default=0, help="frame")
    parser.add_argument("--last", type=int, default=600, help="frame")
    parser.add_argument("--step", type=int, default=6, help="draw every n-th frame")
    parser.add_argument("--pause", type=int, default=100, help="between two pictures, ms")
    parser.add_argument("--quality", type=int, default=70, help="of WebP, 1 to 100")
    return parser.parse_args()


def pictures(room: Room, camera: Camera, first: int, last: int, step: int) -> Iterator[tuple[float, Array]]:
    """Capture time (s) and picture, BGR at the size of a tile, from the source that the room declares."""
    if camera.source is None:
        raise SystemExit(f"camera {camera.name} has no source in the room file")
    folder = Path(camera.source.folder)
    params = {k: folder / v if k == "path" else v for k, v in camera.source.params.items()}
    context = Context(name=f"camera/{camera.name}", room=room, camera=camera)
    stage = load_stage(camera.source.uses)(context, **params)
    stage.setup()
    try:
        for frame in islice(stage.process(), first, last, step):
            small = cv2.resize(frame.pixels, TILE, interpolation=cv2.INTER_AREA)
            bright = cv2.convertScaleAbs(small, alpha=GAIN)
            yield (
                frame.header.time / 1e9,
                cv2.cvtColor(bright, cv2.COLOR_GRAY2BGR) if bright.ndim == 2 else bright,
            )
    finally:
        stage.close()


def positions(tracks: TrackTable, room: Room, time: Array) -> Array:
    """Positions of the T targets of the room at the times (F,) s: (F, T, 3) m, NaN if unknown."""
    xyz = np.full((len(time), len(room.targets), 3), np.nan)
    for target, name in enumerate(room.targets):
        rows = np.flatnonzero(np.array(tracks.objects)[tracks.target] == name)
        if len(rows):
            row, distance = nearest(tracks.time[rows], time)
            known = distance < SAME_TIME
            xyz[known, target] = tracks.xyz[rows[row[known]]]
    return xyz


def target_colors(room: Room) -> list[Color]:
    """BGR of each target: the strongest hue of its template."""
    colors = []
    for number, target in enumerate(room.targets.values()):
        histograms = [np.asarray(h) for h in target.hue_histogram.values()]
        bins = len(histograms[0]) if histograms else 6
        peak = int(np.sum(histograms, axis=0).argmax()) if histograms else number
        hue = np.array([[[(peak + 0.5) / bins * 255, 200, 255]]]).astype(np.uint8)
        blue, green, red = cv2.cvtColor(hue, cv2.COLOR_HSV2BGR_FULL)[0, 0].tolist()
        colors.append((blue, green, red))
    return colors


def compose(images: Sequence[Array], number: int, plan: FloorPlan) -> Array:
    """One picture of the animation: tiles on the left, floor plan on the right."""
    now = plan.xyz[number]
    cameras = plan.room.cameras.values()
    tiles = [tile(camera, image, now, plan.colors) for camera, image in zip(cameras, images, strict=True)]
    columns = 2 if len(tiles) < 7 else 4
    tiles += [np.full_like(tiles[0], PAPER)] * (-len(tiles) % columns)
    left = np.vstack([np.hstack(tiles[i : i + columns]) for i in range(0, len(tiles), columns)])
    return np.hstack([left, plan.draw(number, left.shape[0])])


def tile(camera: Camera, image: Array, xyz: Array, colors: list[Color]) -> Array:
    """The camera's picture with a ring around each target (T, 3) m that the tracker knows."""
    picture = image.copy()
    for center, color in zip(project(camera, xyz) * TILE / camera.size, colors, strict=True):
        if ((center > 0) & (center < TILE)).all():
            cv2.circle(picture, rounded(center), 9, color, 2, cv2.LINE_AA)
    cv2.putText(picture, f"{camera.name} {camera.kind}", (6, 14), FONT, 0.38, INK, 1, cv2.LINE_AA)
    return cv2.copyMakeBorder(picture, 0, GAP, 0, GAP, cv2.BORDER_CONSTANT, value=PAPER)


def rounded(point: Array) -> tuple[int, int]:
    """The pixel that a point (2,) px lies in."""
    x, y = np.rint(point).astype(int).tolist()
    return x, y


class FloorPlan:
    """The room from above: cameras, a grid of metres, and the trails of the targets."""

    def __init__(self, room: Room, xyz: Array, colors: list[Color]) -> None:
        """Fit the plan around cameras and tracks; xyz: (F, T, 3) m; colors: of the T targets."""
        self.room, self.xyz, self.colors = room, xyz, colors
        centers = [camera.center for camera in room.cameras.values()]
        known = np.vstack([*centers, xyz[np.isfinite(xyz[..., 0])]])[:, :2]
        self.low, self.high = known.min(axis=0) - 0.5, known.max(axis=0) + 0.5

    def draw(self, number: int, size: int) -> Array:
        """The plan at one frame: (size, size, 3) BGR."""
        picture = np.full((size, size, 3), PAPER, np.uint8)
        self.grid(picture)
        for camera in self.room.cameras.values():
            start, end = self.pixels(
                np.array([camera.center, camera.center + 0.45 * camera.rotation[2]]), size
            )
            cv2.arrowedLine(picture, start, end, (150, 150, 150), 1, cv2.LINE_AA, tipLength=0.4)
        for target in range(len(self.colors)):
            self.trail(picture, number, target)
        for name, spot, color in zip(self.room.targets, self.xyz[number], self.colors, strict=True):
            if np.isfinite(spot).all():
                ((x, y),) = self.pixels(spot[None], size)
                cv2.circle(picture, (x, y), 5, color, -1, cv2.LINE_AA)
                cv2.putText(picture, name, (x + 8, y + 4), FONT, 0.4, color, 1, cv2.LINE_AA)
        cv2.putText(picture, "floor plan, 1 m grid", (10, 18), FONT, 0.42, INK, 1, cv2.LINE_AA)
        return picture

    def grid(self, picture: Array) -> None:
        """A line each metre."""
        size = len(picture)
        for x in np.arange(np.ceil(self.low[0]), self.high[0]):
            start, end = self.pixels(np.array([[x, self.low[1]], [x, self.high[1]]]), size)
            cv2.line(picture, start, end, GRID, 1)
        for y in np.arange(np.ceil(self.low[1]), self.high[1]):
            start, end = self.pixels(np.array([[self.low[0], y], [self.high[0], y]]), size)
            cv2.line(picture, start, end, GRID, 1)

    def trail(self, picture: Array, number: int, target: int) -> None:
        """The path of the target, fading with age; broken while it was lost."""
        past = self.xyz[max(0, number - TRAIL) : number + 1, target]
        points = self.pixels(np.nan_to_num(past), len(picture))
        known = np.isfinite(past[:, 0])
        for i in range(1, len(points)):
            if known[i] and known[i - 1]:
                age = OLDEST * (len(points) - i) / TRAIL
                faded = tuple(
                    round(c * (1 - age) + p * age) for c, p in zip(self.colors[target], PAPER, strict=True)
                )
                cv2.line(picture, points[i - 1], points[i], faded, 2, cv2.LINE_AA)

    def pixels(self, points: Array, size: int) -> list[tuple[int, int]]:
        """Points (N, 2 or 3) m as pixels of a square plan, y up."""
        span = (self.high - self.low).max()
        middle = (self.high + self.low) / 2
        unit = (points[:, :2] - middle) / span * [1, -1] + 0.5
        return [rounded(one) for one in unit * size]


if __name__ == "__main__":
    main()
