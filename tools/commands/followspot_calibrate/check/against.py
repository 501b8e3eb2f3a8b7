"""Two calibrations of the same cameras, compared after a similarity alignment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.errors import InputError
from followspot.geometry import project, project_local, ray
from followspot.messages import Array
from followspot_calibrate.check.alignment import aligned

STEPS = 10
"""Points along each side of the cube, and of the picture, in which images are compared."""
REACH = 0.5
"""Half the side of that cube over the cameras' median distance from its middle."""


@dataclass(frozen=True, eq=False)
class CameraDifference:
    """One camera in two calibrations: the second, moved onto the first, minus the first.

    center_mm, angle_deg between the orientations; mean_px between images of the same points: NaN if one of
    the calibrations has no poses. focal_percent; principal_px between the principal points; lens_px: mean
    over the picture between images of the same directions, in the camera's own frame.
    """

    name: str
    other: str
    center_mm: float
    angle_deg: float
    mean_px: float
    focal_percent: float
    principal_px: float
    lens_px: float

    @property
    def judged_px(self) -> float:
        """The difference in the picture: of points, or of directions if there are no poses."""
        return self.mean_px if np.isfinite(self.mean_px) else self.lens_px


@dataclass(frozen=True, eq=False)
class Comparison:
    """Two calibrations. scale: a metre of the second in metres of the first, NaN if one has no poses."""

    cameras: tuple[CameraDifference, ...]
    scale: float
    notes: tuple[str, ...]


def compare(mine: Sequence[Camera], other: Sequence[Camera]) -> Comparison:
    """The differences between calibrations. Raises InputError if they share fewer than two cameras.

    Cameras correspond by name, or by order if no two names agree.
    """
    pairs, notes = _pairs(mine, other)
    here, there = [a for a, _ in pairs], [b for _, b in pairs]
    scale, places = np.nan, [(np.nan, np.nan, np.nan)] * len(pairs)
    if posed(here) and posed(there):
        onto = aligned(here, there)
        scale, points = onto.scale, common_points(here)
        places = [_places(a, onto.camera(b), points) for a, b in pairs]
    else:
        notes = (*notes, "one of the calibrations has no camera poses: only the lenses are compared")
    differences = tuple(
        CameraDifference(a.name, b.name, *place, *_lenses(a, b))
        for (a, b), place in zip(pairs, places, strict=True)
    )
    sizes = [
        f"{a.name} has pictures of {a.size[0]}x{a.size[1]} px here and {b.size[0]}x{b.size[1]} px there"
        for a, b in pairs
        if a.size != b.size
    ]
    return Comparison(differences, scale, (*notes, *sizes))


def posed(cameras: Sequence[Camera]) -> bool:
    """True if the cameras have poses: in a file without poses all are at the origin."""
    places = np.array([np.column_stack([c.rotation, c.translation]) for c in cameras])
    return bool(np.ptp(places, axis=0).max() > 1e-9)


def common_points(cameras: Sequence[Camera]) -> Array:
    """Points (N, 3) m in front of the cameras: a cube around the middle of their axes, if two see it."""
    middle = common_view_point(cameras)
    centers = np.array([camera.center for camera in cameras])
    side = REACH * float(np.median(np.linalg.norm(centers - middle, axis=1)))
    grid = np.linspace(-side, side, STEPS)
    cube = middle + np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3)
    seen = sum(_inside(camera, project(camera, cube)).astype(int) for camera in cameras)
    return np.asarray(cube[seen >= 2])


def common_view_point(cameras: Sequence[Camera]) -> Array:
    """The point nearest to all optical axes, (3,) m."""
    across = np.array([np.eye(3) - np.outer(c.rotation[2], c.rotation[2]) for c in cameras])
    moment = np.einsum("nij,nj->i", across, np.array([c.center for c in cameras]))
    return np.asarray(np.linalg.lstsq(across.sum(axis=0), moment, rcond=None)[0])


def _places(a: Camera, moved: Camera, points: Array) -> tuple[float, float, float]:
    """Distance of the centres, mm, angle between the orientations, deg, mean distance of the images, px."""
    here, there = project(a, points), project(moved, points)
    shown = _inside(a, here) & np.isfinite(there).all(axis=1)
    apart = np.linalg.norm(here - there, axis=1)[shown]
    turn = a.rotation @ moved.rotation.T
    angle = np.arctan2(np.linalg.norm(turn - turn.T) / np.sqrt(2), np.trace(turn) - 1)
    mean = float(apart.mean()) if len(apart) else np.nan
    return 1000 * float(np.linalg.norm(moved.center - a.center)), float(np.degrees(angle)), mean


def _lenses(a: Camera, b: Camera) -> tuple[float, float, float]:
    """Difference of the focal lengths, %, of the principal points, px, mean distance of the images, px."""
    focal = [camera.matrix[0, 0] + camera.matrix[1, 1] for camera in (a, b)]
    principal = float(np.linalg.norm(b.matrix[:2, 2] - a.matrix[:2, 2]))
    width, height = a.size
    grid = np.meshgrid(np.linspace(0, width - 1, STEPS), np.linspace(0, height - 1, STEPS))
    pixel = np.stack(grid, axis=-1).reshape(-1, 2)
    directions = ray(a, pixel) @ a.rotation.T
    apart = np.linalg.norm(project_local(b, directions) - pixel, axis=1)
    return 100 * float(focal[1] / focal[0] - 1), principal, float(np.nanmean(apart))


def _inside(camera: Camera, pixel: Array) -> Array:
    """(N,) bool: in the picture."""
    return np.asarray(((pixel > -0.5) & (pixel < np.array(camera.size) - 0.5)).all(axis=1))


def _pairs(
    mine: Sequence[Camera], other: Sequence[Camera]
) -> tuple[list[tuple[Camera, Camera]], tuple[str, ...]]:
    """Cameras that correspond, and what has to be said about it."""
    there = {camera.name: camera for camera in other}
    pairs = [(camera, there[camera.name]) for camera in mine if camera.name in there]
    if not pairs and len(mine) == len(other) > 1:
        order = ", ".join(f"{a.name} = {b.name}" for a, b in zip(mine, other, strict=True))
        return list(zip(mine, other, strict=True)), (f"no names agree; cameras correspond by order: {order}",)
    if len(pairs) < 2:
        text = f"the calibrations share {len(pairs)} cameras"
        remedy = f"name them alike: {', '.join(c.name for c in mine)} and {', '.join(there)}"
        raise InputError.of(text, remedy)
    alone = {c.name for c in (*mine, *other)} - {a.name for a, _ in pairs}
    return pairs, (f"only in one of the two: {', '.join(sorted(alone))}",) if alone else ()
