"""The filter and the life cycle of a target: tracked, missing, lost, recovered (sections 3.7 and 3.8)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import make_room, positions_at

from followspot.context import Context
from followspot.tracking import LOST, MISSING, PREDICTED, STATES, TRACKED
from followspot_balls.kalman import Kalman
from followspot_balls.motion import Motion, initiated, predict, update
from followspot_target_filter.life_cycle import AWAY, DEPARTURES
from followspot_target_filter.stage import Outputs

FPS = 30
HERE, THERE = (0.0, 0.0, 1.0), (2.0, 0.0, 1.0)


def kalman(**params: object) -> Kalman:
    stage = Kalman(Context(room=make_room()), **params)
    stage.setup()
    return stage


def watch(
    stage: Kalman,
    frames: int,
    first: int = 0,
    seen: bool = True,
    place: tuple[float, float, float] = HERE,
    **how: object,
) -> list[Outputs]:
    """Run frames in which target 0 is measured at rest, or is not."""
    places = {0: place} if seen else {}
    return [
        stage.process(positions_at(places, (first + i) / FPS, **how))  # type: ignore[arg-type]
        for i in range(frames)
    ]


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


def test_a_target_is_doubted_only_where_three_cameras_have_it_in_view_and_one_sees_colours() -> None:
    room = make_room()
    two = replace(room, cameras={name: room.cameras[name] for name in ("cam0", "cam1")})
    gray = replace(room, cameras={n: replace(c, kind="infrared") for n, c in room.cameras.items()})
    for stage in (Kalman(Context(room=two)), Kalman(Context(room=gray)), kalman(doubt_frames=0)):
        stage.setup()
        watch(stage, 40)
        assert poor(stage, 30) == [TRACKED] * 30


def stated(stage: Kalman, frames: int, first: int = 40, fps: int = FPS) -> list[float]:
    """The largest sigma of target 0, m, in frames in which one candidate shows it."""
    return [
        float(stage.process(positions_at({0: HERE}, i / fps, support=1)).tracks.sigma.max())
        for i in range(first, first + frames)
    ]


def test_a_track_that_few_candidates_show_states_that_it_may_have_left_its_target() -> None:
    """At a rate of departures, and no farther than tracks go astray; what three show at once is there."""
    stage = kalman()
    before = float(watch(stage, 40)[-1].tracks.sigma.max())
    sigma = stated(stage, 300)
    assert np.all(np.diff(sigma[1:]) > 0)
    left = 1 - np.exp(-DEPARTURES * np.array([10, 300]) / FPS)
    assert np.take(sigma, [9, 299]) == pytest.approx(np.hypot(before, AWAY * np.sqrt(left)), rel=0.02)
    assert watch(stage, 1, first=340)[0].tracks.sigma.max() == pytest.approx(before, rel=0.02)


def test_what_a_track_states_depends_on_the_time_and_not_on_the_number_of_frames() -> None:
    slow, fast = kalman(measurement_sigma=1e-4), kalman(measurement_sigma=1e-4)
    for stage, fps in ((slow, 30), (fast, 120)):
        for i in range(fps):
            stage.process(positions_at({0: HERE}, i / fps))
    assert stated(slow, 30, first=30)[-1] == pytest.approx(
        stated(fast, 120, first=120, fps=120)[-1], rel=0.01
    )


def test_a_track_that_nothing_speaks_against_states_what_its_filter_does() -> None:
    """As where a target is never doubted: two cameras are all there are, no colours, a mark, or no doubt."""
    room = make_room()
    two = replace(room, cameras={name: room.cameras[name] for name in ("cam0", "cam1")})
    gray = replace(room, cameras={n: replace(c, kind="infrared") for n, c in room.cameras.items()})
    others = kalman(doubt_frames=0), kalman(marks={"red": HERE})
    for stage in (Kalman(Context(room=two)), Kalman(Context(room=gray)), *others):
        stage.setup()
        watch(stage, 40)
        assert stated(stage, 30) == pytest.approx([stage.motion.estimate.sigma[0].max()] * 30, rel=1e-3)


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
