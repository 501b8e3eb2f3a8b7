"""Existence of targets: evidence confirms, its absence ends, rivals make it wait."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_balls.association.existence import (
    NO_RIVALS,
    Confirmation,
    Existence,
    OddsRules,
    Rivals,
    TargetCandidates,
    restored,
    with_track,
    without_track,
)

RULES = OddsRules(memory=0.9, drift=0.5, maximum=8.0, deletion=-1.0)
CONFIRMATION = Confirmation(absence=0.5, odds=2.0, margin=3.0, reach=0.15)
HERE, THERE = (0.0, 0.0, 1.0), (0.5, 0.0, 1.0)


def candidates(gains: dict[tuple[float, float, float], float], complete: bool = False) -> TargetCandidates:
    count = len(gains)
    xyz = np.array(list(gains), float).reshape(-1, 3)
    return TargetCandidates(xyz, np.array(list(gains.values()), float), np.full(count, complete))


def after(
    frames: int, gains: dict[tuple[float, float, float], float], alike: int = 0, complete: bool = False
) -> list[int]:
    """The confirmed candidate in each frame."""
    existence, chosen = Existence.unknown(), []
    for _ in range(frames):
        existence, one = without_track(
            existence, candidates(gains, complete), None, alike, RULES, CONFIRMATION
        )
        chosen.append(one)
    return chosen


def test_evidence_of_nothing_ends_a_long_standing_target_in_a_bounded_time() -> None:
    existence = Existence.unknown()
    for _ in range(1000):
        existence = with_track(existence, 6.0, np.array(HERE), RULES)
    assert existence.odds == RULES.maximum
    frames = 0
    while existence.odds >= RULES.deletion:
        existence = with_track(existence, 0.0, np.array(HERE), RULES)
        frames += 1
    assert 10 <= frames <= 20
    assert existence.rivals.xyz == pytest.approx(np.array([HERE]))
    assert existence.rivals.odds == pytest.approx([existence.odds])


def test_weak_evidence_in_every_frame_keeps_a_target() -> None:
    existence = Existence.unknown()
    for _ in range(100):
        existence = with_track(existence, 0.6, np.array(HERE), RULES)
    assert existence.odds == pytest.approx(1.0, abs=0.01)
    assert not len(existence.rivals.odds)


def test_half_a_step_twice_is_nearly_a_step() -> None:
    """Odds and evidence go by time, so that a faster camera neither prolongs nor ends a track."""
    before = Existence(4.0, False, NO_RIVALS)
    whole = with_track(before, 1.3, np.array(HERE), RULES)
    half = with_track(with_track(before, 1.3, np.array(HERE), RULES, 0.5), 1.3, np.array(HERE), RULES, 0.5)
    assert whole.odds == pytest.approx(0.9 * 4 + 1.3 - 0.5)
    assert with_track(before, 1.3, np.array(HERE), RULES, 0.5).odds == pytest.approx(0.9**0.5 * 4 + 0.4)
    assert half.odds == pytest.approx(whole.odds, abs=0.03)


def test_odds_are_bounded_below_too() -> None:
    existence = Existence.unknown()
    for _ in range(50):
        existence = with_track(existence, -20.0, np.array(HERE), RULES)
    assert existence.odds == -RULES.maximum


def test_strong_evidence_is_certain_at_once_and_weak_evidence_after_some_frames() -> None:
    assert after(1, {HERE: 6.0}) == [0]
    assert after(4, {HERE: 1.2, THERE: 0.0}) == [-1, -1, -1, 0]
    assert after(30, {HERE: 0.4, THERE: -0.5}) == [-1] * 30


def test_a_place_far_ahead_of_its_rivals_needs_little_evidence() -> None:
    assert after(1, {HERE: 1.0, THERE: -6.0}) == [0]
    assert after(1, {HERE: 1.0, THERE: -4.9}) == [-1]
    assert after(1, {HERE: 0.4, THERE: -9.0}) == [-1]


def test_two_places_wait_until_one_leads() -> None:
    assert after(20, {HERE: 3.0, THERE: 3.0}) == [-1] * 20
    assert after(4, {THERE: 1.5, HERE: 3.0})[-1] == 1


def test_places_of_targets_that_look_the_same_are_no_rivals() -> None:
    assert after(1, {HERE: 6.0, THERE: 5.0}, alike=1) == [0]
    assert after(1, {HERE: 6.0, THERE: 5.0, (0, 1, 1): 5.0}, alike=1) == [-1]


def test_three_views_that_agree_need_less() -> None:
    assert after(1, {HERE: 1.2, THERE: -1.5}, complete=True) == [0]
    assert after(1, {HERE: 1.2, THERE: -1.5}) == [-1]
    assert after(1, {HERE: 1.2, THERE: 0.0}, complete=True) == [-1], "but still a lead"


def test_odds_of_places_are_bounded() -> None:
    existence = Existence.unknown()
    for _ in range(30):
        existence, _ = without_track(
            existence, candidates({HERE: 6.0, THERE: -20.0}), None, 0, RULES, CONFIRMATION
        )
    assert existence.odds == RULES.maximum
    assert existence.rivals.odds == pytest.approx([2 * RULES.maximum, -RULES.maximum])


def test_a_place_that_was_certain_stays_so_while_more_speaks_for_it() -> None:
    existence, _ = without_track(Existence.unknown(), candidates({HERE: 6.0}), None, 0, RULES, CONFIRMATION)
    assert existence.confirmed
    existence, one = without_track(
        existence, candidates({HERE: -1.0, THERE: 3.0}), None, 0, RULES, CONFIRMATION
    )
    assert one == 0
    existence, one = without_track(
        existence, candidates({HERE: -6.0, THERE: -0.5}), None, 0, RULES, CONFIRMATION
    )
    assert one == -1, "and does not pass its certainty on"


def test_a_place_moves_with_its_candidates() -> None:
    existence = Existence.unknown()
    for step in range(20):
        place = (0.1 * step, 0.0, 1.0)
        existence, one = without_track(existence, candidates({place: 1.2}), None, 0, RULES, CONFIRMATION)
    assert one == 0
    assert existence.rivals.xyz == pytest.approx(np.array([place]))


def test_a_place_that_no_camera_looked_at_waits_and_an_empty_one_falls() -> None:
    places = Rivals(np.array([HERE, THERE]), np.array([2.0, 1.0]))
    before = Existence(0.0, False, places)
    existence, one = without_track(before, candidates({}), np.array(HERE), 0, RULES, CONFIRMATION)
    assert one == -1
    assert dict(zip(existence.rivals.xyz[:, 0], existence.rivals.odds, strict=True)) == pytest.approx(
        {0.0: 0.9 * 2 - 1.0, 0.5: 1.0}
    )


def test_the_state_of_a_stage_brings_it_back() -> None:
    before = Existence(1.5, True, Rivals(np.array([HERE]), np.array([2.0])))
    again = restored({**before._asdict(), "rivals": before.rivals._asdict()})
    assert again[:2] == before[:2]
    assert again.rivals.xyz == pytest.approx(before.rivals.xyz)
    assert again.rivals.odds == pytest.approx(before.rivals.odds)
