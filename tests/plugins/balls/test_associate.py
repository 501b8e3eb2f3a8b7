"""Association of candidates with targets: the ball among paint, reflectors and other balls."""

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
    Place,
    associated,
    candidates_of,
    red,
    stage,
    views,
)
from tests.plugins.balls.scene import forecast_at

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.tracking import LOST, MISSING, Forecast
from followspot_balls.associate_tracked import AssociateTracked
from followspot_balls.association.existence import Existence, Rivals
from followspot_balls.association.hypotheses import hypotheses
from followspot_balls.association.view_association import NO_HYPOTHESES, ViewAssociation, WeighedHypotheses


def of_tracked() -> AssociateTracked:
    made = AssociateTracked(Context(room=ROOM))
    made.setup()
    return made


@pytest.mark.parametrize("forecast", [None, seal(Forecast.empty())])
def test_a_ball_in_clear_view_is_found_at_once(forecast: Forecast | None) -> None:
    found = red(associated(stage(), views({BALL: EVERYWHERE}), forecast))
    assert found == pytest.approx(np.tile(BALL, (6, 1)), abs=1e-6)


def test_paint_that_infrared_cameras_do_not_see_is_no_ball() -> None:
    associate = stage()
    for _ in range(30):
        assert not len(associated(associate, views({PATCH: COLOR}), None).xyz)


def test_a_track_on_paint_goes_silent_and_one_on_a_ball_stays() -> None:
    for cameras, ends in ((COLOR, True), (EVERYWHERE[1:], False)):
        associate = stage()
        lengths = []
        for _ in range(30):
            found = associated(associate, views({PATCH: cameras}), forecast_at([PATCH, (-1, 0, 0.5)]))
            lengths.append(len(red(found)))
        assert (lengths[-1] == 0) == ends
        assert not ends or lengths.index(0) <= 15, "within half a second"


def test_infrared_blobs_alone_prolong_a_track_for_a_bounded_time() -> None:
    associate = stage()
    there = forecast_at([BALL, (-1, 0, 0.5)])
    for _ in range(20):
        associated(associate, views({BALL: EVERYWHERE}), there)
    lengths = [len(red(associated(associate, views({BALL: INFRARED}), there))) for _ in range(40)]
    assert lengths[0] > 0
    assert lengths.index(0) <= 20
    assert not any(lengths[lengths.index(0) :])


def test_the_whole_ball_outvotes_fragments_beside_it() -> None:
    """A right pair against more, but smaller blobs that agree on another place."""
    beside = (BALL[0] + 0.06, BALL[1] - 0.05, BALL[2] + 0.08)
    shown = {BALL: ("cam2", "cam1"), beside: ("cam0", "cam3", "cam1")}
    small = tuple(
        seal(replace(b, area=np.where(np.arange(len(b.area)) == len(b.area) - 1, 4.0, 28.0)))
        if b.camera != "cam2"
        else b
        for b in views(shown)
    )
    found = red(associated(stage(), small, forecast_at([BALL, (-1, 0, 0.5)])))
    assert len(found)
    assert np.linalg.norm(found - BALL, axis=1).min() < 1e-6


def test_an_infrared_blob_of_another_tracked_ball_is_not_taken() -> None:
    other = (BALL[0] + 0.16, BALL[1], BALL[2])
    owners = [[True, False], [False, True]]
    shown = {BALL: ("cam0", "cam2", "cam3"), other: EVERYWHERE}
    found = associated(stage(), views(shown, owners), forecast_at([BALL, other]))
    assert np.linalg.norm(red(found) - BALL, axis=1).max() < 0.02
    theirs = found.xyz[found.targets[:, 1]]
    assert np.linalg.norm(theirs - other, axis=1).max() < 0.02


def test_two_places_that_are_as_likely_wait() -> None:
    twice = {BALL: EVERYWHERE, (-0.6, -0.5, 0.9): EVERYWHERE}
    associate = stage()
    for _ in range(5):
        assert not len(associated(associate, views(twice), None).xyz)
    for _ in range(5):
        found = associated(associate, views({BALL: EVERYWHERE}), None)
    assert len(red(found)) == 6


def test_views_that_never_show_the_ball_are_forgiven_and_doubted() -> None:
    associate, there = stage(), forecast_at([BALL, (-1, 0, 0.5)])
    for _ in range(20):
        associated(associate, views({BALL: ("cam0", "cam1", "cam3")}), there)
    assert associate.detection[0, [0, 1, 3]] == pytest.approx([0.94] * 3, abs=0.01)
    assert associate.detection[0, 2] < 0.15
    before = associate.existence[0].odds
    associated(associate, views({BALL: ("cam1", "cam3")}), there)
    lost = before - associate.existence[0].odds
    for _ in range(3):
        associated(associate, views({BALL: ("cam1", "cam3")}), there)
    before = associate.existence[0].odds
    associated(associate, views({BALL: ("cam1", "cam3")}), there)
    assert before - associate.existence[0].odds < 0.5 * lost


def test_pairs_that_disagree_lead_to_the_place_on_which_all_views_agree() -> None:
    """Each view is off by 1 px another way, as the centres of fragments are."""
    off = {"cam0": (1.0, 0.0), "cam1": (0.0, 1.0), "cam2": (1.0, 0.0), "cam3": (0.0, 1.0)}
    small = tuple(
        seal(replace(b, xy=b.xy + np.array(off[b.camera]), area=np.full(len(b.area), 14.0)))
        for b in views({BALL: EVERYWHERE})
    )
    candidates = candidates_of(small)
    row = np.flatnonzero(candidates.targets[:, 0])
    target, tracked = np.zeros_like(row), np.zeros(2, bool)
    associate = stage()
    begun = hypotheses(candidates.xyz, row, target, None, tracked, associate.prior)
    blobs = associate.evidence.blobs(candidates, None, tracked)
    found, _ = associate.evidence.likeliest(begun, blobs, associate.detection)
    assert len(row) > 2
    assert np.ptp(begun.xyz, axis=0).max() > 0.02
    assert np.ptp(found.xyz, axis=0).max() < 0.005


def test_a_frame_that_speaks_against_a_track_by_blobs_that_hardly_fit_leaves_it_nothing() -> None:
    """Specks beside the ball in two of four views that all showed it; whole blobs are followed still."""
    off = {"cam0": (1.0, 0.0), "cam1": (0.0, -1.0)}
    there, two = forecast_at([BALL, (-1, 0, 0.5)]), views({BALL: tuple(off)})
    specks = tuple(
        seal(replace(b, xy=b.xy + np.array(off.get(b.camera, (0.0, 0.0))), area=np.full(len(b.area), 2.0)))
        for b in two
    )
    stages: tuple[tuple[ViewAssociation, int], ...] = (
        (stage(), 0),
        (stage(least_evidence=-100.0), 1),
        (stage(least_fit=-100.0), 1),
        (of_tracked(), 1),
    )
    for associate, left in stages:
        for _ in range(5):
            associated(associate, views({BALL: EVERYWHERE}), there)
        assert len(red(associated(associate, specks, there))) == left
        assert len(red(associated(associate, two, there))) == 1


def test_the_only_place_of_a_track_is_left_out_if_the_frame_contradicts_it_and_its_blobs_hardly_fit() -> None:
    there, tracked = forecast_at([BALL, (-1, 0, 0.5)]), np.ones(2, bool)
    for evidence, fit, chosen in ((-2.0, 4.0, []), (-2.0, 6.0, [0]), (0.0, 4.0, [0])):
        weight, first, one = np.array([-evidence]), np.zeros(1, int), np.zeros(1, bool)
        found = WeighedHypotheses(np.array([BALL]), first, weight, -weight, np.array([fit]), one)
        assert stage().decide(found, there, tracked, np.zeros(2, bool)).tolist() == chosen


def test_a_place_that_no_view_shows_fits_nothing() -> None:
    associate, tracked = stage(), np.zeros(2, bool)
    candidates = candidates_of(views({BALL: EVERYWHERE}))
    two, row = np.zeros(2, int), np.arange(2)
    found = hypotheses(np.array([BALL, (0.8, -0.7, 1.6)]), row, two, None, tracked, associate.prior)
    blobs = associate.evidence.blobs(candidates, None, tracked)
    seen = associate.evidence.views(found, blobs, associate.detection)
    there, nowhere = associate.weighed(found, seen, candidates, tracked).fit
    assert there > 5.0
    assert nowhere == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(("state", "falls"), [(LOST, True), (MISSING, False), (None, True)])
def test_a_lost_target_is_searched_everywhere_and_a_missing_one_near_its_last_place(
    state: int | None, falls: bool
) -> None:
    """A place elsewhere that shows nothing falls if it was searched, and waits otherwise."""
    associate, nothing = stage(), np.zeros(2, bool)
    places = Rivals(np.array([PATCH]), np.array([1.0]))
    associate.existence[0] = Existence(0.0, False, places)
    there = forecast_at([BALL, (-1, 0, 0.5)])
    forecast = None if state is None else seal(replace(there, state=np.full(2, state, np.uint8)))
    associate.decide(NO_HYPOTHESES, forecast, nothing, nothing)
    p = associate.params
    left = p.memory - p.absence - p.drift if falls else 1.0
    assert associate.existence[0].rivals.odds == pytest.approx([left])


def test_frames_that_follow_each_other_faster_count_as_less() -> None:
    counts = []
    for period in (1 / 15, 1 / 30, 1 / 60):
        associate = stage()
        there = seal(replace(forecast_at([BALL, (-1, 0, 0.5)]), period=period))
        for _ in range(40):
            associated(associate, views({BALL: EVERYWHERE}), there)
        count, alone = 0, views({BALL: INFRARED})
        while len(red(associated(associate, alone, there))):
            count += 1
        counts.append(count)
    slow, usual, fast = counts
    assert slow == usual, "a frame counts as one step at most"
    assert 2 * usual <= fast < 4 * usual


def test_of_two_equal_places_the_one_at_the_forecast_is_taken() -> None:
    beside = (BALL[0] - 0.12, BALL[1] + 0.05, BALL[2])
    for here, there in ((BALL, beside), (beside, BALL)):
        twice = views({BALL: EVERYWHERE, beside: EVERYWHERE})
        found = red(associated(stage(), twice, forecast_at([here, (-1, 0, 0.5)])))
        assert np.linalg.norm(found - here, axis=1).max() < 0.02
        assert np.linalg.norm(found - there, axis=1).min() > 0.1


def test_a_vague_forecast_of_another_ball_claims_its_blobs_less() -> None:
    owners, tracked = [[True, True]], np.ones(2, bool)
    candidates = candidates_of(views({BALL: EVERYWHERE}, owners))
    evidence = stage().evidence
    exact, vague = (
        evidence.blobs(candidates, forecast_at([(-1, 0, 0.5), BALL], sigma), tracked).rival_density[0, :, 0]
        for sigma in (0.01, 0.1)
    )
    assert (vague < 0.3 * exact).all()
    assert (vague > 0).all()


def test_unknown_numbers_spoil_nothing() -> None:
    """A frame of NaN counts as one without candidates of them; what is known beside it is used."""
    there = forecast_at([BALL, (-1, 0, 0.5)])
    nowhere = seal(replace(there, xyz=np.where([[True], [False]], np.nan, there.xyz)))
    found = candidates_of(views({BALL: EVERYWHERE}), there)
    mixed = seal(replace(found, xyz=np.where(np.arange(len(found.xyz))[:, None] == 0, np.nan, found.xyz)))
    unknown = seal(replace(found, xyz=np.full_like(found.xyz, np.nan)))
    associate, empty = stage(), stage()
    for to, frame in ((associate, unknown), (empty, found.where(np.zeros(0, int)))):
        to.process(found, there)
        to.process(frame, there)
    assert [one.odds for one in associate.existence] == [one.odds for one in empty.existence]
    for candidates, forecast in ((mixed, there), (found, nowhere), (found, there)):
        left = red(associate.process(candidates, forecast).candidates)
        assert len(left)
        assert np.isfinite(left).all()
        assert np.isfinite([one.odds for one in associate.existence]).all()
        assert np.isfinite(associate.detection).all()


def test_a_light_on_the_ray_of_the_last_view_does_not_take_the_ball_along() -> None:
    """cam0 and cam1 see the ball, cam2 a light on the ray from cam1 through it; then cam0 is covered."""
    eye = ROOM.cameras["cam1"].center
    ray = np.array(BALL) - eye
    light: Place = tuple(BALL + 0.22 * ray / np.linalg.norm(ray))
    there = forecast_at([BALL, (-1, 0, 0.5)])
    for associate in (of_tracked(), stage()):
        for _ in range(8):
            found = red(associated(associate, views({BALL: ("cam0", "cam1"), light: ("cam2",)}), there))
            assert found == pytest.approx(np.array([BALL]), abs=1e-6)
        before = candidates_of(views({BALL: ("cam1",), light: ("cam2",)}), there)
        assert np.linalg.norm(red(before) - BALL, axis=1) == pytest.approx([0.22], abs=1e-3)
        assert not len(red(associate.process(before, there).candidates))


def test_nothing_seen_is_nothing_found_and_the_state_comes_back() -> None:
    associate, again = stage(), stage()
    for _ in range(3):
        associated(associate, views({PATCH: COLOR}), forecast_at([PATCH, (-1, 0, 0.5)]))
    again.restore(associate.state())
    assert [one.odds for one in again.existence] == [one.odds for one in associate.existence]
    assert again.detection == pytest.approx(associate.detection)
    assert again.detection[0, 1] < again.detection[0, 0], "paint"
    assert not len(associated(again, views({}), None).xyz)
