"""A small room with two colour and two infrared cameras around one spot, and messages made in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from followspot.geometry import project, undistort
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, stamped
from followspot.room import Camera, Room, Target
from followspot.tracking import TRACKED, Blobs, Candidates, Forecast, Frame, Positions
from followspot_balls.detection.strip import Strip
from followspot_balls.fusion.validation import Fusion
from followspot_balls.templates.from_clip import color_spots, color_template

AnyFusion = TypeVar("AnyFusion", bound=Fusion)
RADIUS = 0.0762
SIZE = (160, 120)
HUES = {"red": 0, "green": 5, "another red": 0}
BGR = {"red": (0, 0, 255), "green": (0, 255, 0), "another red": (0, 0, 255)}


def look_at(name: str, kind: str, center: tuple[float, float, float]) -> Camera:
    """A camera there that looks at the point 1 m above the middle of the floor."""
    C = np.array(center)
    forward = np.array([0.0, 0.0, 1.0]) - C
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(forward, right), forward])
    K = np.array([[150.0, 0.0, 79.5], [0.0, 150.0, 59.5], [0.0, 0.0, 1.0]])
    return Camera(name, kind, SIZE, K, np.array([-0.1, 0.02, 0.0, 0.0, 0.0]), R, -R @ C)


def make_room(targets: tuple[str, ...] = ("red", "green")) -> Room:
    cameras = [
        look_at("cam0", "color", (3.0, 0.0, 3.0)),
        look_at("cam1", "infrared", (0.0, 3.0, 3.0)),
        look_at("cam2", "color", (-3.0, 0.5, 3.0)),
        look_at("cam3", "infrared", (0.5, -3.0, 3.0)),
    ]
    names = [c.name for c in cameras]
    templates = {
        t: Target(
            t,
            RADIUS,
            {n: np.eye(16)[HUES[t]] for n in names},
            dict.fromkeys(names, (15.0, 60.0)),
            dict.fromkeys(names, (60.0, 255.0)),
        )
        for t in targets
    }
    planes = {"floor": np.array([0.0, 0.0, 1.0, 0.0])}
    return Room("test", {c.name: c for c in cameras}, planes, templates)


def picture(camera: Camera, balls: dict[str, Array], white_core: bool = False) -> Frame:
    """What a camera sees of balls of the given colours and places: anti-aliased discs."""
    pixels = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    for name, place in balls.items():
        center, side = project(camera, np.stack([place, place + camera.rotation[0] * RADIUS]))
        radius = float(np.linalg.norm(side - center))
        color = BGR[name] if camera.kind == "color" else (220, 220, 220)
        disc(pixels, center, radius, color)
        if white_core and camera.kind == "color":
            disc(pixels, center, radius * 0.5, (255, 255, 255))
    kept = pixels if camera.kind == "color" else np.ascontiguousarray(pixels[..., :1])
    return seal(Frame(camera=camera.name, pixels=kept))


def whole_strip(width: int) -> Strip:
    """A strip with the whole picture as its only part."""
    return Strip(np.zeros(width, int), np.zeros((1, 2), int))


def disc(pixels: Array, center: Array, radius: float, color: tuple[int, int, int]) -> None:
    """Draw a disc at a sub-pixel place with a soft edge."""
    y, x = np.mgrid[: pixels.shape[0], : pixels.shape[1]]
    share = np.clip(radius + 0.5 - np.hypot(x - center[0], y - center[1]), 0, 1)[..., None]
    pixels[:] = np.rint(pixels * (1 - share) + share * np.array(color)).astype(np.uint8)


def forecast_at(places: list[tuple[float, float, float]], sigma: float = 0.01) -> Forecast:
    """Tracked targets at rest there."""
    xyz = np.array(places)
    count = len(places)
    return seal(
        Forecast(
            period=1 / 30,
            state=np.full(count, TRACKED, np.uint8),
            xyz=xyz,
            velocity=np.zeros((count, 3)),
            covariance=np.tile(np.eye(3) * sigma**2, (count, 1, 1)),
            last=xyz.copy(),
            before=xyz.copy(),
        )
    )


def blobs_of(camera: Camera, places: list[tuple[float, float, float]], targets: list[list[bool]]) -> Blobs:
    """Exact blobs of points of the room."""
    pixel = project(camera, np.array(places, float).reshape(-1, 3))
    count = len(places)
    return seal(
        Blobs(
            camera=camera.name,
            xy=undistort(camera, pixel),
            pixel=pixel,
            area=np.full(count, 28.0),
            similarity=np.ones(count),
            targets=np.array(targets, bool).reshape(count, 2),
        )
    )


def candidates_at(
    places: list[tuple[float, float, float]],
    labelled: list[bool] | None = None,
    confirmed: list[bool] | None = None,
    epipolar: list[float] | None = None,
    targets: list[list[bool]] | None = None,
    view: list[tuple[int, int]] | None = None,
) -> Candidates:
    """Candidates there, of whole balls that two cameras show: everywhere the same ones unless told."""
    count = len(places)
    xyz = np.array(places, float).reshape(-1, 3)
    pair = np.array(view or [(0, 1)] * count, np.int32).reshape(-1, 2)
    centers = np.array([camera.center for camera in make_room().cameras.values()])
    away = np.linalg.norm(xyz[:, None] - centers[pair], axis=2)
    return seal(
        Candidates(
            cameras=("cam0", "cam1", "cam2", "cam3"),
            xyz=xyz,
            view=pair,
            blob=np.zeros((count, 2), np.int32),
            xy=np.zeros((count, 2, 2)),
            area=np.pi * np.square(150.0 * RADIUS / away),
            epipolar=np.array(epipolar or [0.0] * count, float),
            labelled=np.array([True] * count if labelled is None else labelled, bool),
            confirmed=np.array([True] * count if confirmed is None else confirmed, bool),
            evident=np.array([True] * count if confirmed is None else confirmed, bool),
            targets=np.array([[True]] * count if targets is None else targets, bool).reshape(count, -1),
            clutter=np.ones((count, 2)),
        )
    )


def positions_at(
    places: dict[int, tuple[float, float, float]],
    seconds: float,
    confirmed: bool = True,
    support: int = 6,
    predicted: bool = False,
    evident: bool = True,
    sigma: float = np.nan,
) -> Positions:
    """One measurement for each of some targets, at a time. sigma: m, NaN if it is unknown."""
    count = len(places)
    message = Positions(
        target=np.array(list(places), np.int32),
        xyz=np.array(list(places.values()), float).reshape(-1, 3),
        covariance=np.tile(np.eye(3) * sigma**2, (count, 1, 1)),
        support=np.full(count, support, np.int32),
        confirmed=np.full(count, confirmed),
        evident=np.full(count, evident and confirmed),
        iterations=np.ones(count, np.int32),
        predicted=np.full(count, predicted),
    )
    return seal(stamped(message, Header("test", 0, round(seconds * 1e9))))


def learn_color(frames: Sequence[Array]) -> tuple[Array, tuple[float, float]]:
    """Hue histogram (16,) of a glowing target, and its smallest and largest area, px."""
    spots = color_spots(frames)
    return color_template(spots), spots.extremes


def unweighed(fusion: AnyFusion) -> AnyFusion:
    """The fusion, which finds lost targets without weighing all views, as in a room with depth cameras."""
    fusion.recovery.depth = True
    return fusion
