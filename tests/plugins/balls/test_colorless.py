"""Infrared cameras alone prolong a track for a bounded time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import blobs_of, forecast_at, make_room, positions_at

from followspot.context import Context
from followspot.geometry import ray
from followspot.message_checks.sealing import seal
from followspot.tracking import MISSING, Candidates, Forecast
from followspot_balls.association.infrared_only import Colorless, ColorlessParams
from followspot_balls.bundle_fusion import Bundle
from followspot_balls.mean_shift import MeanShift
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs

BALL = (0.1, 0.2, 1.2)
ROOM = make_room()
THERE = forecast_at([BALL, (-1.0, 0.0, 0.5)])
INFRARED, ALL = ("cam1", "cam3"), tuple(ROOM.cameras)
Fusion = type[MeanShift] | type[Bundle]
FUSIONS = pytest.mark.parametrize("fusion", [MeanShift, Bundle])


def candidates_of(shown: tuple[str, ...], place: tuple[float, float, float] = BALL) -> Candidates:
    """Those of the first target, which these cameras show; infrared blobs may be anyone's."""
    verify, triangulate = VerifyPairs(Context(room=ROOM)), Triangulate(Context(room=ROOM))
    verify.setup()
    triangulate.setup()
    blobs = tuple(
        blobs_of(camera, [place] * (name in shown), [[True, name in INFRARED]] * (name in shown))
        for name, camera in ROOM.cameras.items()
    )
    return seal(triangulate.process(seal(verify.process(blobs)), THERE))


def stage(fusion: Fusion, room: object = ROOM, **params: float) -> MeanShift | Bundle:
    made = fusion(Context(room=room), **params)  # type: ignore[arg-type]
    made.setup()
    return made


def first_silent(fuse: MeanShift | Bundle, frames: int = 60) -> int | None:
    """The frame in which the first target has no position, seen by infrared cameras alone."""
    alone = candidates_of(INFRARED)
    for number in range(frames):
        if 0 not in fuse.process(alone, THERE).target:
            return number
    return None


@FUSIONS
def test_a_target_that_infrared_cameras_alone_show_is_silent_after_a_second(fusion: Fusion) -> None:
    assert first_silent(stage(fusion)) == 30
    assert first_silent(stage(fusion, colorless_time=0.5)) == 15
    assert first_silent(stage(fusion, colorless_time=0.0)) is None


@FUSIONS
def test_one_pair_of_infrared_cameras_shows_no_target_that_is_missing(fusion: Fusion) -> None:
    missing = replace(THERE, state=np.full(2, MISSING, np.uint8))
    assert 0 not in stage(fusion).process(candidates_of(INFRARED), missing).target
    assert 0 in stage(fusion).process(candidates_of(ALL), missing).target
    first = stage(fusion).process(candidates_of(ALL), Forecast.empty())  # knows no targets yet
    assert 0 in first.target


@FUSIONS
def test_a_colour_camera_that_shows_it_starts_the_time_anew(fusion: Fusion) -> None:
    fuse = stage(fusion)
    assert first_silent(fuse) == 30
    assert 0 in fuse.process(candidates_of(ALL), THERE).target
    assert first_silent(fuse) == 30


@FUSIONS
def test_a_target_out_of_the_pictures_of_all_colour_cameras_stays(fusion: Fusion) -> None:
    small = {n: replace(c, size=(8, 8)) if c.kind == "color" else c for n, c in ROOM.cameras.items()}
    assert first_silent(stage(fusion, replace(ROOM, cameras=small))) is None


def test_the_border_of_a_distorted_picture_belongs_to_it() -> None:
    first = ROOM.cameras["cam0"]
    barrel = replace(first, distortion=np.array([-0.3, 0.1, 0.0, 0.0, -0.012]))
    place = first.center + 2.0 * ray(barrel, np.array([[3.0, 60.0]]))
    for cameras, there in (({"cam0": barrel}, True), ({"cam0": first}, False)):
        made = Colorless(replace(ROOM, cameras=cameras), ColorlessParams())
        assert made.in_picture(place).tolist() == [there]


@FUSIONS
def test_rooms_without_colour_cameras_and_with_depth_cameras_know_no_such_limit(fusion: Fusion) -> None:
    for kind in ("infrared", "depth"):
        other = {n: replace(c, kind=kind) if c.kind == "color" else c for n, c in ROOM.cameras.items()}
        assert first_silent(stage(fusion, replace(ROOM, cameras=other))) is None


@FUSIONS
def test_a_successor_goes_on_with_the_time(fusion: Fusion) -> None:
    before, after = stage(fusion), stage(fusion)
    for _ in range(20):
        before.process(candidates_of(INFRARED), THERE)
    after.restore(before.state())
    assert first_silent(after) == 10
    assert isinstance(before.state()["since"], np.ndarray)


def test_the_time_goes_on_for_those_alone_that_no_colour_camera_shows() -> None:
    """Two targets are at one place, of which colour cameras show the first from some frame on."""
    colorless = Colorless(ROOM, ColorlessParams())
    both = positions_at({0: BALL, 1: BALL}, 0.0)
    for _ in range(5):
        colorless.bounded(both, candidates_of(INFRARED), THERE)
    assert colorless.since == pytest.approx([5 * THERE.period] * 2)
    colorless.bounded(both, candidates_of(ALL), THERE)
    assert colorless.since == pytest.approx([0.0, 6 * THERE.period])
