"""Simulated rooms by chance: cameras, lenses, targets, people and light, as they differ between labs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.room import Camera, Room, StageUse, Target

COLORS = ("green", "red", "blue", "yellow", "magenta", "cyan")
WALL = 2.3
"""Distance of the wall from the middle of the room, m."""


def random_room(seed: int, frames: int, covered: bool = False) -> Room:
    """A room without templates; equal numbers give equal rooms.

    Four to eight cameras, half of them infrared or nearly so, stand along a square that the balls stay
    within, 2.5 to 4.5 m up, and look at its middle. Three to six balls of 10 to 18 cm, two to six people, up
    to twelve projections a ball, as bright as it at most; 20 to 60 pictures a second. Covered: people hold
    the balls against their bodies, with reflectors and patches beside them; at least five cameras, two balls.
    """
    rng = np.random.default_rng(seed)
    performance = {
        "frames": frames,
        "fps": float(rng.choice([20.0, 30.0, 60.0])),
        "seed": int(rng.integers(1, 1 << 30)),
        "people": int(rng.integers(2, 7)),
        "projections": int(rng.integers(0, 13)),
        "projection_brightness": round(float(rng.uniform(0.4, 1.0)), 2),
        "noise_sigma": round(float(rng.uniform(0.5, 5.0)), 2),
    }
    if covered:
        performance["cover_balls"] = True
    cameras = int(rng.integers(5 if covered else 4, 9))
    color = int(rng.integers(cameras // 2, (cameras + 1) // 2 + 1))
    kinds = ["color"] * color + ["infrared"] * (cameras - color)
    radius = round(float(rng.uniform(0.05, 0.09)), 4)
    names = rng.permutation(COLORS)[: rng.integers(2 if covered else 3, 7)].tolist()
    return Room(
        name=f"random{seed}",
        cameras=_cameras(rng, kinds, performance),
        planes={"floor": np.array([0.0, 0.0, 1.0, 0.0]), "wall": np.array([1.0, 0.0, 0.0, WALL])},
        targets={name: Target(name, radius) for name in names},
        truth=StageUse("sim.truth", performance),
    )


def _cameras(rng: np.random.Generator, kinds: list[str], performance: Mapping[str, Any]) -> dict[str, Camera]:
    """Cameras of these kinds, in any order, spread over the circle around the middle."""
    first = rng.uniform(0, 2 * np.pi)
    cameras = {}
    for number, kind in enumerate(rng.permutation(kinds).tolist()):
        angle = first + 2 * np.pi * (number + rng.uniform(-0.3, 0.3)) / len(kinds)
        across = np.array([np.cos(angle), np.sin(angle)])
        place = rng.uniform(2.0, 2.6) * across / np.abs(across).max()
        place[0] = max(place[0], 0.1 - WALL)  # before the wall
        middle = np.array([*rng.uniform(-0.4, 0.4, 2), rng.uniform(0.3, 1.0)])
        name = f"cam{number}"
        cameras[name] = _camera(
            rng, name, kind, np.array([*place, rng.uniform(2.5, 4.5)]), middle, performance
        )
    return cameras


def _camera(
    rng: np.random.Generator,
    name: str,
    kind: str,
    center: Array,
    middle: Array,
    performance: Mapping[str, Any],
) -> Camera:
    """A camera at `center` that looks at `middle`, with a lens of 65 to 80 degrees."""
    focal = 160 / np.tan(np.radians(rng.uniform(65, 80)) / 2)
    column, row = 160 + rng.uniform(-5, 5), 120 + rng.uniform(-5, 5)
    k1 = rng.uniform(-0.3, 0.0)
    rotation = _looking(middle - center, rng.uniform(-0.1, 0.1))
    return Camera(
        name=name,
        kind=kind,
        size=(320, 240),
        matrix=np.array([[focal, 0, column], [0, focal, row], [0, 0, 1]]),
        distortion=np.array([k1, k1 * k1, *rng.uniform(-0.001, 0.001, 2), 0.0]),
        rotation=rotation,
        translation=-rotation @ center,
        source=StageUse("sim.camera", performance),
    )


def _looking(forward: Array, roll: float) -> Array:
    """Rotation (3, 3) of a camera that looks along `forward`, turned by `roll` (rad) about its axis."""
    z = forward / np.linalg.norm(forward)
    right = np.cross(z, [0.0, 0.0, 1.0])
    x = right / np.linalg.norm(right)
    y = np.cross(z, x)
    c, s = np.cos(roll), np.sin(roll)
    return np.stack([c * x + s * y, -s * x + c * y, z])
