"""Targets that few candidates show: when they are doubted, sought elsewhere, and moved there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import make_room, positions_at
from tests.plugins.balls.watched import FPS, HERE, THERE, kalman, watch

from followspot.context import Context
from followspot.tracking import LOST, PREDICTED, TRACKED
from followspot_balls.kalman import Kalman


def poor(stage: Kalman, frames: int, first: int = 40) -> list[int]:
    """Run frames in which one candidate shows target 0; the state with which each one was searched."""
    states = []
    for number in range(first, first + frames):
        states.append(int(stage.forecast().state[0]))
        watch(stage, 1, first=number, support=1)
    return states


def test_a_target_that_few_candidates_show_is_also_sought_elsewhere_in_every_fifth_frame() -> None:
    stage = kalman()
    watch(stage, 40)
    assert poor(stage, 18) == [TRACKED] * 8 + [LOST, *[TRACKED] * 4] * 2
    assert stage.tracks().xyz[0] == pytest.approx(HERE)
    watch(stage, 1, first=58, support=3)
    assert poor(stage, 9, first=59) == [TRACKED] * 8 + [LOST]


def test_a_target_that_cameras_of_one_kind_alone_show_is_doubted() -> None:
    """A patch in its colour beside reflectors: colour cameras agree on it, infrared ones do not."""
    stage = kalman()
    before = watch(stage, 40)[-1].tracks.sigma.max()
    states = []
    for number in range(40, 49):
        states.append(int(stage.forecast().state[0]))
        tracks = watch(stage, 1, first=number, support=6, confirmed=False)[0].tracks
    assert states == [TRACKED] * 8 + [LOST]
    assert tracks.sigma.max() > 0.03 > before
    watch(stage, 1, first=49, support=6, confirmed=True)
    assert poor(stage, 5, first=50) == [TRACKED] * 5


def test_a_target_that_only_one_kind_of_camera_can_see_is_not_doubted() -> None:
    """The infrared cameras look away: that none shows the target says nothing."""
    room = make_room()
    about = np.diag([1.0, -1.0, -1.0])
    away = {
        name: replace(c, rotation=about @ c.rotation, translation=about @ c.translation)
        if c.kind == "infrared"
        else c
        for name, c in room.cameras.items()
    }
    more = {"cam4": replace(room.cameras["cam0"], name="cam4")}
    stage = Kalman(Context(room=replace(room, cameras={**away, **more})))
    stage.setup()
    watch(stage, 40)
    for number in range(40, 60):
        assert stage.forecast().state[0] == TRACKED
        tracks = watch(stage, 1, first=number, support=6, confirmed=False)[0].tracks
    assert tracks.sigma.max() < 0.03


def test_a_target_is_doubted_only_where_three_cameras_have_it_in_view_and_one_sees_colours() -> None:
    room = make_room()
    two = replace(room, cameras={name: room.cameras[name] for name in ("cam0", "cam1")})
    gray = replace(room, cameras={n: replace(c, kind="infrared") for n, c in room.cameras.items()})
    for stage in (Kalman(Context(room=two)), Kalman(Context(room=gray)), kalman(doubt_frames=0)):
        stage.setup()
        watch(stage, 40)
        assert poor(stage, 30) == [TRACKED] * 30


@pytest.mark.parametrize(("frames", "moved"), [(1, False), (2, True)])
def test_a_doubted_target_moves_to_another_place_that_two_frames_show(frames: int, moved: bool) -> None:
    stage = kalman()
    watch(stage, 40)
    poor(stage, 8)
    for outputs in watch(stage, frames, first=48, place=THERE, support=3)[: 2 - moved]:
        assert outputs.tracks.state.tolist() == [PREDICTED]
        assert outputs.tracks.xyz[0] == pytest.approx(HERE)
    assert stage.tracks().xyz[0] == pytest.approx(THERE if moved else HERE)
    assert poor(stage, 1, first=50) == [TRACKED if moved else LOST]


def test_what_one_view_shows_is_not_doubted_for_want_of_candidates() -> None:
    stage = kalman()
    watch(stage, 40)
    assert LOST not in poor(stage, 5)
    for number in range(45, 65):
        assert stage.forecast().state[0] != LOST
        watch(stage, 1, first=number, support=0, predicted=True, confirmed=False)


def test_a_target_that_was_lost_meanwhile_is_not_doubted_at_once() -> None:
    stage = kalman()
    watch(stage, 40)
    poor(stage, 6)
    watch(stage, 30, first=46, seen=False)
    watch(stage, 3, first=76, support=1)
    assert poor(stage, 5, first=79) == [TRACKED] * 5


def test_a_target_that_a_mark_tells_from_the_others_is_not_doubted() -> None:
    """No colour would tell whether what is found elsewhere is this target."""
    stage = kalman(marks={"red": HERE})
    watch(stage, 40)
    assert poor(stage, 20) == [TRACKED] * 20


def test_one_that_is_nowhere_else_keeps_its_course() -> None:
    """In the frames in which it is sought everywhere, what is found at its forecast is the target itself."""
    stage = kalman()
    for number in range(60):
        place = {0: (number / FPS, 0.0, 1.0)}
        now = stage.process(positions_at(place, number / FPS, support=6 if number < 40 else 1)).tracks
        assert number < 40 or now.state.tolist() == [TRACKED]
        assert number < 40 or now.xyz[0] == pytest.approx(place[0], abs=0.005)
        assert number < 40 or now.velocity[0] == pytest.approx((1, 0, 0), abs=0.05)
