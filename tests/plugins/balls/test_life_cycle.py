"""The filter and the life cycle of a target: tracked, missing, lost, recovered (sections 3.7 and 3.8)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import make_room, positions_at
from tests.plugins.balls.watched import FPS, HERE, THERE, kalman, watch

from followspot.context import Context
from followspot.room import StageUse
from followspot.tracking import LOST, MISSING, PREDICTED, STATES, TRACKED
from followspot_balls.filtering.motion import Motion, initiated, predict, update
from followspot_balls.kalman import Kalman


def test_a_measured_target_is_tracked_and_an_unseen_one_stays_lost() -> None:
    outputs = watch(kalman(), 3)[-1]
    assert outputs.tracks.target.tolist() == [0]
    assert outputs.forecast.state.tolist() == [TRACKED, LOST]
    assert outputs.tracks.xyz[0] == pytest.approx(HERE)


def test_a_target_is_missing_for_25_frames_then_lost() -> None:
    stage = kalman(local_search_frames=25)
    watch(stage, 40)
    states = [o.forecast.state[0] for o in watch(stage, 26, first=40, seen=False)]
    assert states == [MISSING] * 25 + [LOST]


def test_a_missing_target_that_shows_itself_again_starts_its_counter_anew() -> None:
    stage = kalman(local_search_frames=25)
    watch(stage, 40)
    watch(stage, 20, first=40, seen=False)
    watch(stage, 1, first=60)
    assert watch(stage, 25, first=61, seen=False)[-1].forecast.state[0] == MISSING


def test_a_missing_target_is_sought_everywhere_in_every_second_frame_after_the_first_four() -> None:
    stage = kalman()
    watch(stage, 40)
    states = [o.forecast.state[0] for o in watch(stage, 26, first=40, seen=False)]
    assert states == [MISSING] * 4 + [LOST, MISSING] * 10 + [LOST] * 2


@pytest.mark.parametrize(("near", "frames"), [(4, 5), (25, 24)])
def test_one_that_comes_back_elsewhere_is_found_before_it_is_lost(near: int, frames: int) -> None:
    stage = kalman(local_search_frames=near)
    watch(stage, 40)
    watch(stage, 5, first=40, seen=False)
    found = np.zeros((0, 3))
    passed = 0
    while not len(found):
        everywhere = stage.forecast().state[0] == LOST
        found = watch(stage, 1, first=45 + passed, seen=everywhere, place=THERE, support=1)[0].tracks.xyz
        passed += 1
    assert passed == frames
    assert found[0] == pytest.approx(THERE)


def test_color_alone_finds_a_missing_target_near_its_last_place_and_nowhere_else() -> None:
    stage = kalman()
    watch(stage, 40)
    watch(stage, 5, first=40, seen=False)
    assert stage.forecast().state[0] == LOST
    assert not watch(stage, 1, first=45, confirmed=False)[0].tracks.target.size
    assert stage.forecast().state[0] == MISSING
    assert watch(stage, 1, first=46, confirmed=False)[0].tracks.target.size


@pytest.mark.parametrize(
    ("support", "evident", "found"), [(1, True, True), (2, False, True), (1, False, False)]
)
def test_missing_target_near_its_last_place_needs_one_candidate_less(
    support: int, evident: bool, found: bool
) -> None:
    stage = kalman(return_distance=0.0)
    watch(stage, 40)
    watch(stage, 1, first=40, seen=False)
    assert stage.forecast().state[0] == MISSING
    seen = watch(stage, 1, first=41, support=support, evident=evident)[0]
    assert bool(len(seen.tracks.target)) == found


@pytest.mark.parametrize(
    ("off", "how", "found"),
    [
        (0.08, {"support": 1}, [1, 1]),
        (0.12, {"support": 1}, [0, 0]),
        (0.08, {"support": 0}, [0, 0]),
        (0.04, {"support": 1, "confirmed": False}, [1, 1]),
        (0.08, {"support": 1, "confirmed": False}, [0, 1]),
    ],
    ids=["where it was", "elsewhere", "by no pair", "by one kind", "by one kind, not quite there"],
)
def test_one_candidate_shows_a_missing_target_where_it_was_measured(
    off: float, how: dict[str, object], found: list[int]
) -> None:
    stage = kalman()
    watch(stage, 40)
    watch(stage, 1, first=40, seen=False)
    outputs = watch(stage, 2, first=41, place=(off, 0.0, 1.0), evident=False, **how)  # type: ignore[arg-type]
    assert [len(o.tracks.target) for o in outputs] == found


def test_one_candidate_shows_no_missing_target_that_was_hardly_measured() -> None:
    stage = kalman()
    watch(stage, 20)
    watch(stage, 1, first=20, seen=False)
    assert not any(len(o.tracks.target) for o in watch(stage, 4, first=21, support=1, evident=False))


def led_away(stage: Kalman) -> tuple[float, float, float]:
    """A target that one view leads away from where it was measured, then missing for five frames."""
    watch(stage, 40)
    place = (0.0, 0.0, 1.0)
    for frame in range(12):
        place = (0.02 * (frame + 1), 0.0, 1.0)
        watch(stage, 1, first=40 + frame, place=place, support=0, evident=False, predicted=True)
    watch(stage, 5, first=52, seen=False)
    return place


@pytest.mark.parametrize("between", [0, 1, 3])
def test_where_one_view_led_it_a_missing_target_is_shown_by_two_candidates_in_turn(between: int) -> None:
    stage = kalman()
    place = led_away(stage)
    assert stage.forecast().state[0] == LOST  # sought everywhere, in every second frame
    watch(stage, 1, first=57, seen=False)
    assert not len(watch(stage, 1, first=58, place=place, support=1, evident=False)[0].tracks.target)
    watch(stage, between, first=59, seen=False)
    seen = watch(stage, 1, first=59 + between, place=place, support=1, evident=False)[0]
    assert bool(len(seen.tracks.target)) == (between == 1)


@pytest.mark.parametrize(
    ("sigma", "support", "frames"), [(0.05, 1, 3), (0.05, 2, 1), (0.5, 1, 6), (0.5, 5, 2), (0.5, 6, 1)]
)
def test_vague_position_shows_a_lost_target_by_twice_the_frames(
    sigma: float, support: int, frames: int
) -> None:
    shown = [len(o.tracks.target) for o in watch(kalman(), 6, support=support, sigma=sigma)]
    assert shown == [0] * (frames - 1) + [1] * (7 - frames)


def test_a_frame_without_evidence_confirms_nothing_that_a_vague_one_began() -> None:
    stage = kalman()
    watch(stage, 1, support=5, sigma=0.5, evident=False)
    assert not any(len(o.tracks.target) for o in watch(stage, 5, first=1, support=1, evident=False))
    assert len(watch(stage, 1, first=6, support=1)[0].tracks.target) == 1


def test_there_is_never_a_position_for_a_missing_or_lost_target() -> None:
    stage = kalman()
    watch(stage, 40)
    for outputs in watch(stage, 40, first=40, seen=False):
        assert len(outputs.tracks.target) == 0
    lost = outputs.forecast
    assert not lost.xyz.any()
    assert not lost.covariance.any()


def test_a_lost_target_is_recovered_only_by_a_color_infrared_pair() -> None:
    stage = kalman()
    assert all(len(o.tracks.target) == 0 for o in watch(stage, 20, confirmed=False))
    assert len(watch(stage, 1, first=20)[0].tracks.target) == 1


def test_a_single_pair_is_confirmed_by_frames_in_a_row() -> None:
    shown = [len(o.tracks.target) for o in watch(kalman(confirmation_frames=4), 6, support=1)]
    assert shown == [0, 0, 0, 1, 1, 1]


def test_frames_that_show_it_less_evidently_keep_the_count() -> None:
    stage = kalman(confirmation_frames=3)
    watch(stage, 2, support=1)
    watch(stage, 2, first=2, support=1, evident=False)
    assert len(watch(stage, 1, first=4, support=1)[0].tracks.target) == 1


def test_a_pair_that_is_not_evident_is_not_confirmed_alone() -> None:
    assert all(len(o.tracks.target) == 0 for o in watch(kalman(), 10, support=1, evident=False))
    assert all(len(o.tracks.target) == 0 for o in watch(kalman(), 10, support=2, evident=False))


def test_pairs_that_agree_are_confirmed_at_once() -> None:
    assert len(watch(kalman(), 1, support=3, evident=False)[0].tracks.target) == 1
    assert len(watch(kalman(), 1, support=2)[0].tracks.target) == 1


def test_a_lost_target_is_recovered_within_3_frames_by_one_color_infrared_pair() -> None:
    assert [len(o.tracks.target) for o in watch(kalman(), 3, support=1)] == [0, 0, 1]


def test_a_tracked_target_that_one_view_sees_is_predicted_not_missing() -> None:
    stage = kalman()
    watch(stage, 40)
    outputs = watch(stage, 3, first=40, support=0, evident=False, predicted=True)
    assert [STATES[o.tracks.state[0]] for o in outputs] == ["predicted"] * 3
    assert outputs[-1].forecast.state[0] == PREDICTED
    assert watch(stage, 1, first=43, support=1)[0].tracks.state.tolist() == [TRACKED]


def test_prediction_ends_with_the_missing_frame_counter() -> None:
    stage = kalman(maximum_missed_frames=5)
    watch(stage, 40)
    outputs = watch(stage, 7, first=40, support=0, evident=False, predicted=True)
    assert [o.forecast.state[0] for o in outputs] == [PREDICTED] * 5 + [LOST] * 2


def test_one_view_finds_no_target_that_is_lost_or_missing() -> None:
    stage = kalman()
    assert not any(len(o.tracks.target) for o in watch(stage, 10, predicted=True))
    watch(stage, 40, first=10)
    watch(stage, 2, first=50, seen=False)
    assert not any(len(o.tracks.target) for o in watch(stage, 5, first=52, predicted=True))


def test_a_single_pair_that_jumps_is_a_coincidence() -> None:
    stage = kalman(confirmation_frames=4)
    for i in range(12):
        outputs = stage.process(positions_at({0: (0.5 * (i % 2), 0.0, 1.0)}, i / FPS, support=1))
        assert len(outputs.tracks.target) == 0


def test_a_target_that_was_seen_briefly_is_lost_as_soon() -> None:
    stage = kalman()
    watch(stage, 2)
    states = [o.forecast.state[0] for o in watch(stage, 3, first=2, seen=False)]
    assert states == [MISSING, MISSING, LOST]


@pytest.mark.parametrize("fps", [15, 30, 120])
def test_the_forecast_is_for_the_next_frame_at_any_rate(fps: int) -> None:
    stage = kalman()
    for i in range(60):
        outputs = stage.process(positions_at({0: (1.5 * i / fps, 0.0, 1.0)}, i / fps))
    assert outputs.forecast.period == pytest.approx(1 / fps)
    assert outputs.forecast.velocity[0] == pytest.approx([1.5, 0.0, 0.0], abs=0.02)
    assert outputs.forecast.xyz[0] == pytest.approx([1.5 * 60 / fps, 0.0, 1.0], abs=0.002)
    travel = outputs.forecast.last - outputs.forecast.before
    assert travel[0] == pytest.approx([1.5 / fps, 0.0, 0.0], abs=0.002)


def test_a_missing_target_comes_to_rest_near_its_last_place() -> None:
    stage = kalman(fade_time=0.0)
    for i in range(40):
        stage.process(positions_at({0: (0.05 * i, 0.0, 1.0)}, i / FPS))
    outputs = watch(stage, 3, first=40, seen=False)[-1]
    assert outputs.forecast.xyz[0] == pytest.approx(outputs.forecast.last[0])


def test_prediction_and_update_follow_the_equations() -> None:
    motion = initiated(Motion.zero(1), np.array([0]), np.array([[1.0, 2.0, 3.0]]), np.eye(3)[None] * 4.0, 1.0)
    ahead = predict(motion, 0.5, 2.0)
    # P = 4 + 0.5^2 * 1 + (0.5^2 / 2)^2 * 2^2 = 4.3125; P_v = 1 + 0.5^2 * 4 = 2; P_xv = 0.5 + 0.125 * 0.5 * 4
    assert ahead.covariance[0, 0, 0] == pytest.approx(4.3125)
    assert ahead.covariance[0, 3, 3] == pytest.approx(2.0)
    assert ahead.covariance[0, 0, 3] == pytest.approx(0.75)
    measured, _ = update(ahead, np.array([0]), np.array([[2.0, 2.0, 3.0]]), np.eye(3)[None] * 4.3125)
    assert measured.xyz[0] == pytest.approx([1.5, 2.0, 3.0])
    assert measured.velocity[0] == pytest.approx([0.75 / 8.625, 0.0, 0.0])
    assert measured.covariance[0, 0, 0] == pytest.approx(4.3125 / 2)


def test_a_successor_carries_on_where_its_predecessor_stopped() -> None:
    old, new = kalman(), kalman()
    watch(old, 10)
    new.restore(old.state())
    a, b = watch(old, 1, first=10)[0], watch(new, 1, first=10)[0]
    assert a.tracks.xyz.tobytes() == b.tracks.xyz.tobytes()
    assert a.forecast.covariance.tobytes() == b.forecast.covariance.tobytes()


@pytest.mark.parametrize(
    ("frames", "truth", "told"),
    [(3, False, True), (0, False, False), (3, True, False)],
    ids=["one of two", "none", "scores tell"],
)
def test_targets_that_are_not_found_are_named_at_the_end(frames: int, truth: bool, told: bool) -> None:
    said: list[str] = []
    room = make_room()
    if truth:
        room = replace(room, truth=StageUse("cameras.truth_csv", {}))
    stage = Kalman(Context(room=room, warn=said.append))
    stage.setup()
    watch(stage, frames)
    stage.close()
    first, second = room.targets
    assert [f"not found: {second} (found: {first})" in text for text in said] == [True] * told
