"""Tracks of overlapping zones become one track a target, without jumps and with one identity."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from followspot import Array
from followspot.context import Context
from followspot.messages import Header, identical, stamped
from followspot.room import Room, Target
from followspot.tracking import PREDICTED, TRACKED, Tracks
from followspot_tracking.merge import Merge

FPS = 60
ROOM = Room(targets={"red": Target("red", 0.07), "green": Target("green", 0.07)})


def merge(**params: float) -> Merge:
    stage = Merge(Context(room=ROOM), **params)
    stage.setup()
    return stage


def tracks(
    frame: int,
    places: dict[int, tuple[float, float, float] | Array],
    sigma: float = 0.005,
    state: int = TRACKED,
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Tracks:
    """A message of one tracker: targets at places, m."""
    count = len(places)
    found = Tracks(
        target=np.array(list(places), np.int32),
        state=np.full(count, state, np.uint8),
        xyz=np.array(list(places.values()), float).reshape(count, 3),
        velocity=np.tile(velocity, (count, 1)),
        sigma=np.full((count, 3), sigma),
    )
    return stamped(found, Header("camera/cam0", frame, round(frame * 1e9 / FPS)))


def crossing(frame: int) -> Array:
    """A target that crosses the room at 2 m/s, m."""
    return np.array([-2.0 + 2.0 * frame / FPS, 0.3, 1.0])


def handed_over(bias: Array, **params: float) -> Array:
    """Errors of a target, (F, 3) m, that the first zone sees until frame 70, the second from 50 on."""
    stage, errors = merge(**params), []
    for frame in range(160):
        place = crossing(frame)
        first = {0: place} if frame < 70 else {}
        second = {0: place + bias} if frame >= 50 else {}
        moving = {"velocity": (2.0, 0.0, 0.0)}
        out = stage.process((tracks(frame, first, **moving), tracks(frame, second, **moving)))  # type: ignore[arg-type]
        assert out.target.tolist() == [0]
        errors.append(out.xyz[0] - place)
    return np.array(errors)


def test_the_tracks_of_one_zone_pass_unchanged() -> None:
    stage = merge()
    for frame in range(5):
        own = tracks(frame, {1: crossing(frame)}, velocity=(2.0, 0.0, 0.0))
        out = stage.process((own, tracks(frame, {})))
        assert out.target.tolist() == [1]
        np.testing.assert_allclose(out.xyz, own.xyz, atol=1e-12)
        np.testing.assert_allclose(out.velocity, own.velocity)
        np.testing.assert_allclose(out.sigma, own.sigma)


def test_estimates_that_agree_are_weighted_by_their_covariance_and_not_counted_twice() -> None:
    out = merge().process((tracks(0, {0: (0, 0, 1)}, 0.01), tracks(0, {0: (0.01, 0, 1)}, 0.02)))
    # Exponents 4 : 1 of informations 4 : 1.
    np.testing.assert_allclose(out.xyz, [[0.01 / 17, 0, 1]])
    alone = merge().process((tracks(0, {0: (0, 0, 1)}, 0.01), tracks(0, {0: (0, 0, 1)}, 0.01)))
    np.testing.assert_allclose(alone.sigma, 0.01)


def test_the_sigma_tells_what_trackers_disagree_about_and_what_is_not_yet_taken_over() -> None:
    stage = merge()
    out = stage.process((tracks(0, {0: (0, 0, 1)}, 0.01), tracks(0, {0: (0.06, 0, 1)}, 0.01)))
    np.testing.assert_allclose(out.sigma, [[np.hypot(0.01, 0.03), 0.01, 0.01]])
    out = stage.process((tracks(1, {}), tracks(1, {0: (0.06, 0, 1)}, 0.01)))
    left = 0.03 * np.exp(-1 / FPS / 0.5)
    np.testing.assert_allclose(out.sigma, [[np.hypot(0.01, left), 0.01, 0.01]])


def test_a_bias_between_zones_makes_no_jump_and_is_taken_over() -> None:
    bias = np.array([0.0, 0.05, -0.02])
    errors = handed_over(bias)
    steps = np.linalg.norm(np.diff(errors, axis=0), axis=1)
    assert steps.max() < 1.05 * np.linalg.norm(bias) / FPS / 0.5
    np.testing.assert_allclose(errors[49], 0.0, atol=1e-9)
    np.testing.assert_allclose(errors[-1], bias, rtol=0.06)


def test_without_a_bias_the_hand_over_is_exact() -> None:
    assert np.abs(handed_over(np.zeros(3))).max() < 1e-9


def test_a_shorter_hand_over_takes_a_bias_over_sooner() -> None:
    bias = np.array([0.0, 0.05, 0.0])
    soon, late = (handed_over(bias, handover_time=seconds)[80, 1] for seconds in (0.1, 1.0))
    assert 0.04 < soon <= 0.05
    assert late < 0.03


def test_one_that_becomes_unsure_makes_no_jump_either() -> None:
    stage, last = merge(), np.zeros(3)
    for frame in range(60):
        vague = 0.1 if 20 <= frame < 40 else 0.005
        out = stage.process((tracks(frame, {0: (0, 0, 1)}, vague), tracks(frame, {0: (0.06, 0, 1)}, 0.005)))
        assert frame == 0 or abs(out.xyz[0, 0] - last[0]) < 0.0015
        last = out.xyz[0]


def test_a_zone_that_disagrees_is_left_out_until_it_is_alone() -> None:
    stage = merge()
    real, false = (0.0, 0.0, 1.0), (1.0, 0.0, 1.0)
    assert stage.process((tracks(0, {0: real}), tracks(0, {}))).xyz[0].tolist() == list(real)
    out = stage.process((tracks(1, {0: real}), tracks(1, {0: false}, 0.001)))
    np.testing.assert_allclose(out.xyz[0], real, atol=1e-9)
    out = stage.process((tracks(2, {}), tracks(2, {0: false}, 0.001)))
    np.testing.assert_allclose(out.xyz[0], false, atol=1e-9)


def test_of_a_new_target_a_measured_place_counts_before_a_predicted_one() -> None:
    predicted = tracks(0, {0: (1.0, 0, 1)}, 0.001, PREDICTED)
    out = merge().process((predicted, tracks(0, {0: (0, 0, 1)}, 0.05)))
    assert out.xyz[0].tolist() == [0, 0, 1]
    assert out.state.tolist() == [TRACKED]
    assert merge().process((predicted,)).state.tolist() == [PREDICTED]


def test_a_lost_target_has_no_row_and_returns_where_it_is_found() -> None:
    stage = merge()
    stage.process((tracks(0, {0: (0, 0, 1)}), tracks(0, {})))
    assert len(stage.process((tracks(1, {}), tracks(1, {}))).target) == 0
    assert stage.process((tracks(2, {}), tracks(2, {0: (0.1, 0, 1)}))).xyz[0].tolist() == [0.1, 0, 1]


def test_targets_that_the_room_does_not_have_are_left_out_and_said() -> None:
    said: list[str] = []
    stage = Merge(Context(room=ROOM, warn=said.append))
    stage.setup()
    place = np.array([0.0, 0.3, 1.0])
    for frame in range(2):
        message = tracks(frame, {0: place, 7: place, -1: place, 2**31 - 1: place})
        assert stage.process((message,)).target.tolist() == [0]
    assert said == ["tracks of targets that the room does not have are left out"]


def test_the_message_of_a_zone_may_be_missing() -> None:
    stage, bias = merge(), np.array([0.0, 0.05, 0.0])
    errors = []
    for frame in range(30):
        place, moving = crossing(frame), (2.0, 0.0, 0.0)
        both = (
            tracks(frame, {0: place}, velocity=moving),
            tracks(frame, {0: place + bias}, velocity=moving),
        )
        out = stage.process(both[1:] if frame % 7 == 6 else both)
        errors.append(out.xyz[0, 1] - place[1])
    assert np.abs(np.diff(errors)).max() < 0.002


def test_another_instance_goes_on_from_a_checkpoint() -> None:
    first, second = merge(), merge()
    for frame in range(20):
        given_ = (
            tracks(frame, {0: crossing(frame)}),
            tracks(frame, {0: crossing(frame) + 0.02} if frame > 5 else {}),
        )
        expected = first.process(given_)
        if frame < 12:
            second.restore(first.state())
        else:
            assert identical(second.process(given_), expected)


@given(st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(1e-4, 0.2)), min_size=1, max_size=4))
def test_a_new_target_is_between_its_estimates_and_no_surer_than_the_surest(
    found: list[tuple[float, float]],
) -> None:
    out = merge().process(tuple(tracks(0, {0: (x, 0, 1)}, sigma) for x, sigma in found))
    places, sigmas = zip(*found, strict=True)
    assert min(places) - 1e-9 <= out.xyz[0, 0] <= max(places) + 1e-9
    assert out.sigma.min() >= min(sigmas) * (1 - 1e-9)


def test_unknown_numbers_of_a_tracker_spoil_nothing() -> None:
    stage, nowhere = merge(), (np.nan, np.nan, np.nan)
    sigmas = [0.005, 0.005, 0.005, 0.005, np.nan, 0.005]
    for frame in range(6):
        first = tracks(frame, {0: crossing(frame)})
        second = tracks(frame, {0: nowhere if frame == 3 else crossing(frame)}, sigmas[frame])
        out = stage.process((first, second))  # type: ignore[arg-type]
        assert out.target.tolist() == [0]
        assert np.abs(out.xyz[0] - crossing(frame)).max() < 1e-9
        assert np.isfinite(out.sigma).all()
    only = merge()
    assert not len(only.process((tracks(0, {0: nowhere}),)).target)  # type: ignore[arg-type]
    assert only.process((tracks(1, {0: crossing(1)}),)).target.tolist() == [0]  # type: ignore[arg-type]
