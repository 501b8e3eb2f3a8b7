"""Balls that people hold against their bodies, with reflectors and patches beside them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from followspot import room_file
from followspot.room import Room, Target
from followspot_sim.body import PARTS
from followspot_sim.marks import MARKS
from followspot_sim.parameters import CameraParams
from followspot_sim.rendering.picture import Picture
from followspot_sim.visibility import visible_fraction
from followspot_sim.world import Setting, World

ROOM = room_file.load(Path(__file__).parents[3] / "graphs/rooms/simulated.yaml")
RADIUS = 0.0762
FRAMES = range(0, 900, 15)


def world(seed: int, *, cover: bool) -> World:
    return World(Setting(seed, 60.0, 3, False, -1, (RADIUS,) * 3, (0.0, 0.0, 1.0, 0.0), cover=cover))


def half_covered(of: World) -> float:
    """Share of views in which a quarter to three quarters of a ball is visible."""
    cameras, radii = tuple(ROOM.cameras.values()), np.full(3, RADIUS)
    shares = np.array([visible_fraction(cameras, of.scene(frame), radii) for frame in FRAMES])
    return float(((shares > 0.25) & (shares < 0.75)).mean())


def test_balls_held_against_bodies_are_half_covered_much_more_often() -> None:
    held, shown = (
        np.mean([half_covered(world(seed, cover=cover)) for seed in (1, 2)]) for cover in (True, False)
    )
    assert held > 1.7 * shown


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_such_balls_move_without_jumps_and_not_through_each_other(seed: int) -> None:
    of = world(seed, cover=True)
    path = np.array([of.balls(frame / 60.0) for frame in range(900)])
    assert np.linalg.norm(np.diff(path, axis=0), axis=2).max() * 60 < 6.0
    i, j = np.triu_indices(3, 1)
    assert np.linalg.norm(path[:, i] - path[:, j], axis=2).min() > 2 * RADIUS


def test_marks_follow_the_limbs_of_all_people_and_stay_at_the_body() -> None:
    bare, dressed = world(1, cover=False), world(1, cover=True)
    assert len(bare.scene(100).limbs) == 3 * len(PARTS)
    for frame in FRAMES:
        scene = dressed.scene(frame)
        assert scene.part.tolist() == [*range(len(PARTS))] * 3 + [*range(len(PARTS), len(PARTS + MARKS))] * 3
        body, marks = np.split(scene.limbs.mean(axis=1), [3 * len(PARTS)])
        torso = body.reshape(3, -1, 3)[:, PARTS.index("torso")]
        away = np.linalg.norm(marks.reshape(3, -1, 3) - torso[:, None], axis=2)
        assert away.max() < 0.75


def picture(room: Room, camera: str, *, cover: bool) -> np.ndarray:
    params = CameraParams(seed=3, people=2, projections=0, noise_sigma=0.0, cover_balls=cover)
    of = Picture(params, room, room.cameras[camera])
    out = np.zeros(of.shape, np.uint8)
    of.render(60, out)
    return out


def test_reflectors_shine_in_infrared_and_patches_have_the_colour_of_a_ball() -> None:
    assert (picture(ROOM, "cam1", cover=True) > 200).sum() > 2 * (
        picture(ROOM, "cam1", cover=False) > 200
    ).sum()
    room = replace(ROOM, targets={"blue": Target("blue", RADIUS)})

    def blue(cover: bool) -> int:
        shown = picture(room, "cam0", cover=cover).astype(int)
        return int(((shown[..., 0] > 120) & (shown[..., 0] > 1.5 * shown[..., 2])).sum())

    assert blue(True) > blue(False) + 10
