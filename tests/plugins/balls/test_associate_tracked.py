"""Association of tracked targets that few candidates show, and of sought ones with rival positions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.made_candidates import (
    BALL,
    COLOR,
    EVERYWHERE,
    INFRARED,
    PATCH,
    ROOM,
    associated,
    candidates_of,
    red,
    views,
)
from tests.plugins.balls.scene import forecast_at

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.tracking import LOST, MISSING, TRACKED, Forecast
from followspot_balls.associate import Associate
from followspot_balls.associate_tracked import AssociateTracked
from followspot_balls.association.view_association import WeighedHypotheses


def stage() -> AssociateTracked:
    made = AssociateTracked(Context(room=ROOM))
    made.setup()
    return made


def everywhere() -> Associate:
    made = Associate(Context(room=ROOM))
    made.setup()
    return made


def test_three_candidates_at_the_forecast_settle_where_a_target_is() -> None:
    """Then the fusion chooses among all candidates; fewer leave it those of the likeliest place."""
    beside = (BALL[0] - 0.12, BALL[1] + 0.05, BALL[2])
    there = forecast_at([BALL, (-1, 0, 0.5)])
    for cameras, settled in ((("cam0", "cam1", "cam3"), True), (("cam0", "cam1"), False)):
        twice = candidates_of(views({BALL: cameras, beside: ("cam0", "cam1")}), there)
        assert len(red(twice)) > len(red(everywhere().process(twice, there).candidates))
        left = stage().process(twice, there).candidates
        assert (left is twice) == settled
        assert np.linalg.norm(red(left) - BALL, axis=1).min() < 1e-6


def test_what_settles_a_place_is_near_the_forecast_and_shows_its_colour() -> None:
    associate = stage()
    found = candidates_of(views({BALL: ("cam0", "cam1", "cam3")}))
    colorless = seal(replace(found, labelled=np.zeros_like(found.labelled)))
    exact, aside = forecast_at([BALL, (-1, 0, 0.5)]), (BALL[0] + 0.05, BALL[1], BALL[2])
    assert associate.settled(found, exact).tolist() == [True, False]
    assert associate.settled(colorless, exact).tolist() == [False, False]
    for sigma, settled in ((0.01, False), (0.02, True)):
        assert associate.settled(found, forecast_at([aside, (-1, 0, 0.5)], sigma))[0] == settled


def test_of_a_sought_target_with_rival_places_the_likeliest_is_left() -> None:
    """All views vote on it; fusions count pairs, of which one blob in a wrong place makes several."""
    missing = seal(replace(forecast_at([BALL, (-1, 0, 0.5)]), state=np.array([MISSING, TRACKED], np.uint8)))
    twice = candidates_of(views({BALL: EVERYWHERE, PATCH: ("cam0", "cam1")}))
    assert np.linalg.norm(red(twice) - PATCH, axis=1).min() < 1e-6
    for state in (None, missing):
        left = red(stage().process(twice, state).candidates)
        assert len(left) == 6
        assert np.linalg.norm(left - BALL, axis=1).max() < 1e-6


def test_rival_places_that_are_as_likely_all_stay_so_that_the_position_is_vague() -> None:
    as_likely = candidates_of(views({BALL: ("cam0", "cam1"), PATCH: ("cam0", "cam1")}))
    assert stage().process(as_likely, None).candidates is as_likely


def test_of_sought_targets_without_rival_places_all_candidates_stay() -> None:
    associate = stage()
    near = (BALL[0] + 0.1, BALL[1], BALL[2])
    both = candidates_of(views({BALL: ("cam0", "cam1"), near: ("cam2", "cam3")}))
    assert both.evident.sum() >= 2
    assert associate.process(both, None).candidates is both
    paint = candidates_of(views({PATCH: COLOR}))
    assert associate.process(paint, None).candidates is paint
    tracked = forecast_at([BALL, (-1, 0, 0.5)])
    missing = seal(replace(tracked, state=np.array([MISSING, TRACKED], np.uint8)))
    assert associate.process(paint, missing).candidates is paint


def test_what_was_known_of_a_track_fades_while_it_is_not_followed() -> None:
    associate, missing = after_infrared_views(3)
    before = associate.existence[0].odds
    assert associate.rules.deletion < before < 0
    associate.process(candidates_of(views({PATCH: COLOR})), missing)
    assert associate.existence[0].odds == pytest.approx(associate.rules.memory * before)


def test_a_track_that_is_given_up_returns_near_its_last_position_only_in_its_colour() -> None:
    """The same reflector shows there as before. Elsewhere another track begins."""
    associate, missing = after_infrared_views(30)
    assert associate.existence[0].odds < associate.rules.deletion
    reflector, ball = (candidates_of(views({BALL: cameras}), missing) for cameras in (INFRARED, EVERYWHERE))
    for _ in range(20):
        assert not len(red(associate.process(reflector, missing).candidates))
    again = stage()
    again.restore(associate.state())
    returned = [len(red(again.process(ball, missing).candidates)) for _ in range(2)]
    assert returned[-1] == len(red(ball))
    lost = seal(replace(missing, state=np.array([LOST, TRACKED], np.uint8)))
    assert associate.process(reflector, lost).candidates is reflector
    associated(associate, views({BALL: EVERYWHERE}), forecast_at([BALL, (-1, 0, 0.5)]))
    assert associate.existence[0].odds > 0


def test_what_spoke_against_a_track_is_forgotten_while_nothing_shows_there() -> None:
    associate, missing = after_infrared_views(30)
    nothing = candidates_of(views({}), missing)
    for _ in range(15):
        associate.process(nothing, missing)
    reflector = candidates_of(views({BALL: INFRARED}), missing)
    assert len(red(associate.process(reflector, missing).candidates)) == 1


def after_infrared_views(frames: int) -> tuple[AssociateTracked, Forecast]:
    """A stage after frames in which infrared cameras alone showed a track, and its forecast as missing."""
    associate, tracked = stage(), forecast_at([BALL, (-1, 0, 0.5)])
    for _ in range(frames):
        associated(associate, views({BALL: INFRARED}), tracked)
    return associate, seal(replace(tracked, state=np.array([MISSING, TRACKED], np.uint8)))


def test_a_poor_track_on_a_reflector_goes_silent_and_one_in_its_colour_stays() -> None:
    """No frame alone ends it. What colour cameras alone show may be a ball on the floor."""
    for cameras, ends in ((INFRARED, True), (COLOR, False)):
        associate, there = stage(), forecast_at([PATCH, (-1, 0, 0.5)])
        left = [len(red(associated(associate, views({PATCH: cameras}), there))) for _ in range(30)]
        assert left[0] == 1
        assert (0 in left) == ends
        assert not ends or (left.index(0) <= 15 and not any(left[left.index(0) :]))


def test_a_colour_blob_on_the_ray_to_a_reflector_keeps_it_little_longer() -> None:
    """With it three candidates settle the place, though one blob makes two of them."""
    associate, there = stage(), forecast_at([PATCH, (-1, 0, 0.5)])
    for _ in range(3):
        assert associated(associate, views({PATCH: ("cam0", *INFRARED)}), there).xyz.shape == (3, 3)
    assert 0 < associate.existence[0].odds < 3
    left = [len(red(associated(associate, views({PATCH: INFRARED}), there))) for _ in range(30)]
    assert left[0] == 1
    assert left.index(0) <= 20


def test_depth_cameras_leave_all_candidates_as_they_are() -> None:
    reflector, there = candidates_of(views({PATCH: INFRARED})), forecast_at([PATCH, (-1, 0, 0.5)])
    for kind in ("depth", "color"):
        cameras = {n: replace(c, kind=kind if n == "cam0" else c.kind) for n, c in ROOM.cameras.items()}
        associate = AssociateTracked(Context(room=replace(ROOM, cameras=cameras)))
        associate.setup()
        left = [len(associate.process(reflector, there).candidates.xyz) for _ in range(30)]
        assert (left[-1] > 0) == (kind == "depth")


def test_of_several_places_of_a_track_the_likeliest_one_is_chosen_and_none_where_there_is_none() -> None:
    there = forecast_at([BALL, (-1, 0, 0.5)])
    second_missing = seal(replace(there, state=np.array([TRACKED, MISSING], np.uint8)))
    rank, two = np.array([3.0, 1.0]), np.zeros(2, int)
    found = WeighedHypotheses(np.array([BALL, PATCH]), two, rank, rank, rank, np.zeros(2, bool))
    decided = stage().decide(found, second_missing, np.array([True, False]), np.zeros(2, bool))
    assert decided.tolist() == [0]
