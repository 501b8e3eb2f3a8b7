"""What the views showed while a target was lost: the share of the usual clutter around blobs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import blobs_of, forecast_at, make_room

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.tracking import LOST, TRACKED, Pairs
from followspot_balls.pairs.clutter_map import EVERY, FEW, KNOWN, NEW, USUAL, ClutterMap
from followspot_balls.verify_pairs import VerifyPairs

ROOM = make_room()
MEMORY = 120.0
RED, BLUE = np.array([True, False]), np.array([False, True])
BOTH = RED | BLUE
LAMP, BALL = np.array([[40.0, 40.0]]), np.array([[120.0, 90.0]])
FIRST = np.array([0])
PLACE, ELSEWHERE = (0.0, 0.0, 1.0), (0.8, -0.6, 1.6)
FRAMES = 12
"""Learnt frames of most tests."""


def learnt(
    frames: int = FRAMES, xy: Array = LAMP, lost: Array = RED, targets: Array = RED, memory: float = 1e9
) -> ClutterMap:
    """A map that learnt so many frames of the first view with blobs."""
    clutter = ClutterMap(ROOM, memory)
    for _ in range(EVERY * frames):
        clutter.learn(FIRST, np.zeros(len(xy), int), xy, np.tile(targets, (len(xy), 1)), lost)
    return clutter


def share(clutter: ClutterMap, xy: Array, targets: Array = RED, lost: Array = RED) -> float:
    return float(clutter.share(FIRST, xy, targets[None], lost)[0])


def test_a_lamp_that_stays_is_clutter_and_a_place_where_nothing_was_is_less_than_usual() -> None:
    clutter = learnt()
    assert share(clutter, LAMP) == 1.0
    assert share(clutter, LAMP + 4.0) == 1.0, "in the cell beside it"
    assert share(clutter, LAMP + 8.0) == share(clutter, BALL) == pytest.approx(KNOWN / (KNOWN + FRAMES))


def test_what_comes_and_goes_counts_in_part() -> None:
    clutter = learnt()
    for _ in range(EVERY):
        clutter.learn(FIRST, FIRST, BALL, RED[None], RED)
    assert share(clutter, BALL) == pytest.approx((KNOWN + 1 / USUAL) / (KNOWN + FRAMES + 1))


def test_the_longer_a_view_shows_nothing_the_more_that_says() -> None:
    shares = [share(learnt(frames), BALL) for frames in (0, 1, 4, 16)]
    assert shares[0] == 1.0
    assert shares == sorted(shares, reverse=True)
    assert share(learnt(40, memory=MEMORY), BALL) == pytest.approx(0.14, abs=0.005), "after 120 frames"


def test_nothing_is_learnt_of_targets_that_are_not_lost() -> None:
    assert share(learnt(), BALL, targets=BLUE) == 1.0
    assert share(learnt(), BALL, lost=BLUE) == 1.0
    assert share(learnt(lost=BLUE), BALL, BOTH, BOTH) < 1.0
    assert share(learnt(lost=BLUE), BALL, RED, BOTH) == 1.0, "red was tracked, and sought nowhere else"
    assert share(learnt(targets=BLUE), LAMP, BLUE, BLUE) == 1.0, "blue was tracked"


def test_of_several_lost_targets_the_one_with_least_clutter_counts() -> None:
    clutter = learnt(lost=BOTH)
    assert share(clutter, LAMP, RED, BOTH) == 1.0
    assert share(clutter, LAMP, BOTH, BOTH) == share(clutter, LAMP, BLUE, BOTH) < 1


def test_a_view_that_sends_nothing_learns_nothing() -> None:
    assert learnt().share(np.array([1]), BALL, RED[None], RED).tolist() == [1.0]


def test_what_was_there_long_ago_is_forgotten() -> None:
    clutter = learnt(memory=MEMORY)
    for _ in range(int(4 * MEMORY)):
        clutter.learn(FIRST, np.zeros(0, int), np.zeros((0, 2)), np.zeros((0, 2), bool), RED)
    assert share(clutter, LAMP) == pytest.approx(share(clutter, BALL), abs=0.05)


@pytest.mark.parametrize("times", [5, 100_000])
def test_what_was_learnt_before_a_long_track_is_forgotten_at_once(times: int) -> None:
    clutter = learnt(memory=MEMORY)
    clutter.frame += int(times * MEMORY)  # frames in which no target is lost only count
    assert share(clutter, BALL) == pytest.approx(1.0, abs=0.03)
    for _ in range(EVERY):
        clutter.learn(FIRST, np.zeros(0, int), np.zeros((0, 2)), np.zeros((0, 2), bool), RED)
    assert share(clutter, LAMP) == pytest.approx(KNOWN / (KNOWN + 1), abs=0.1)


@pytest.mark.parametrize("each", [1, 2, 5])
def test_the_memory_is_a_time_however_often_targets_are_lost(each: int) -> None:
    """A missing target is sought everywhere in every second frame."""
    clutter = ClutterMap(ROOM, MEMORY)
    for frame in range(int(5 * MEMORY)):
        clutter.learn(FIRST, FIRST, LAMP, RED[None], RED & (frame % each == 0))
    assert np.log(clutter.weight_now()) == pytest.approx(5.0)


def test_many_blobs_at_once_where_nothing_was_are_lights_that_come_on() -> None:
    clutter = learnt()
    view, targets = np.zeros(FEW + 1, int), np.tile(RED, (FEW + 1, 1))
    lights = np.array([[120.0, 90.0], [80.0, 60.0], [20.0, 80.0], [130.0, 20.0]])
    assert len(lights) == FEW + 1
    assert (clutter.share(view[:FEW], lights[:FEW], targets[:FEW], RED) < NEW).all()
    assert clutter.share(view, lights, targets, RED).tolist() == [1.0] * (FEW + 1)
    both = clutter.share(view, np.vstack([LAMP, lights[:FEW]]), targets, RED)
    assert both[0] == 1.0
    assert (both[1:] < NEW).all(), "the lamp was there before"


def test_a_picture_that_is_mostly_height_takes_no_more_room() -> None:
    tall = {name: replace(camera, size=(2, 100_000)) for name, camera in ROOM.cameras.items()}
    clutter = ClutterMap(replace(ROOM, cameras=tall), MEMORY)
    assert clutter.counts.nbytes < 2e6
    assert clutter.share(FIRST, np.array([[1.0, 99_999.0]]), RED[None], RED).tolist() == [1.0]


def test_a_long_run_learns_as_a_short_one() -> None:
    """The weights of frames grow by e in a memory's time; shares stay as they are."""
    shares = []
    for frames in (200, 2000):
        clutter = learnt(frames, memory=MEMORY)
        shares.append((share(clutter, LAMP), share(clutter, BALL)))
        assert np.isfinite(clutter.counts).all()
    assert shares[0] == pytest.approx(shares[1], rel=0.02)


@pytest.mark.parametrize(
    "xy", [(-1e9, 5.0), (5.0, -1e9), (1e99, np.inf), (-1.0, 60.0), (160.0, 120.0), (np.nan, np.nan)]
)
def test_blobs_outside_the_picture_are_clutter_at_its_border(xy: tuple[float, float]) -> None:
    """Lenses put the corners of a picture outside it once they are undistorted."""
    clutter = learnt(xy=np.array([xy]))
    assert share(clutter, np.array([xy])) == 1.0
    assert share(clutter, np.array([[80.0, 60.0]])) < 1.0


def test_a_map_goes_on_from_its_state() -> None:
    clutter, other = learnt(memory=MEMORY), ClutterMap(ROOM, MEMORY)
    clutter.learn(FIRST, FIRST, LAMP, RED[None], RED)
    other.restore(clutter.state())
    for _ in range(2 * EVERY):
        for each in (clutter, other):
            each.learn(FIRST, FIRST, BALL, RED[None], RED)
        assert [share(other, xy) for xy in (LAMP, BALL)] == [share(clutter, xy) for xy in (LAMP, BALL)]


def verified(stage: VerifyPairs, state: int, place: tuple[float, float, float]) -> Pairs:
    """Pairs of one ball that may be either target, with both in a state."""
    forecast = replace(forecast_at([place] * 2), state=np.full(2, state, np.uint8))
    blobs = tuple(blobs_of(camera, [place], [[True, True]]) for camera in ROOM.cameras.values())
    return seal(stage.process(blobs, forecast))


def test_pairs_bear_the_clutter_around_their_blobs_while_a_target_is_lost() -> None:
    stage = VerifyPairs(Context(room=ROOM))
    stage.setup()
    for _ in range(EVERY * FRAMES):
        pairs = verified(stage, LOST, PLACE)
    assert (pairs.clutter == 1).all()
    assert (verified(stage, LOST, ELSEWHERE).clutter < 0.5).all()
    assert (verified(stage, TRACKED, PLACE).clutter == 1).all()
    successor = VerifyPairs(Context(room=ROOM))
    successor.setup()
    successor.restore(stage.state())
    np.testing.assert_array_equal(*(verified(each, LOST, PLACE).clutter for each in (stage, successor)))
