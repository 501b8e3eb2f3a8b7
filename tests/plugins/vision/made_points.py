"""Points in the pictures of the simulated room, made from its truth: with noise, gaps and false ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from followspot import Context, Room
from followspot.geometry import project
from followspot.plugins.registry import load_stage
from followspot.room_file import load

ROOT = Path(__file__).parents[3]
SIMULATED = ROOT / "graphs/rooms/simulated.yaml"
FPS = 60


def simulated() -> Room:
    return load(SIMULATED)


def truth_of(room: Room, frames: int) -> Iterator[Mapping[str, np.ndarray]]:
    """True places of the balls, (3,) m, frame by frame."""
    assert room.truth is not None
    params = {**room.truth.params, "frames": frames}
    source = load_stage(room.truth.uses)(Context(room=room), **params)
    source.setup()
    for message in source.process():
        yield dict(zip(message.objects, message.xyz, strict=True))


def rows(room: Room, frames: int, sigma: float, seed: int) -> Iterator[tuple[int, str, str, float, float]]:
    """frame, camera, label, x, y: every tenth point is missing, and each picture has a false one a label."""
    rng = np.random.default_rng(seed)
    for frame, there in enumerate(truth_of(room, frames)):
        for camera in room.cameras.values():
            for label, place in there.items():
                x, y = project(camera, place[None])[0] + rng.normal(0, sigma, 2)
                if 0 <= x < camera.size[0] and 0 <= y < camera.size[1] and rng.random() > 0.1:
                    yield frame, camera.name, label, x, y
                yield frame, camera.name, label, *(rng.random(2) * camera.size)


def write_points(path: Path, room: Room, frames: int, sigma: float = 0.7, seed: int = 3) -> None:
    found = rows(room, frames, sigma, seed)
    lines = [f"{frame},{camera},{label},{x:.3f},{y:.3f}\n" for frame, camera, label, x, y in found]
    path.write_text("frame,camera,label,x,y\n" + "".join(lines))
