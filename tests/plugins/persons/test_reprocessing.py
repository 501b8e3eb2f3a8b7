"""What the slow instance says late: people begin where they were then, and are led to the present."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.drawn import SECOND, drawn, perspective, picture_of, standing
from tests.plugins.persons.shown import FastInstance

from followspot_persons.fast_instance.reprocessing import SPACING, PastPicture, PastPictures


def past(*times):
    """Pictures of these times, s, of which those of the last two seconds are kept."""
    picture, kept = picture_of(perspective(), drawn(perspective())), PastPictures()
    for time in times:
        kept = kept.extended(PastPicture.kept(round(time * SECOND), picture, 1.0), 2.0)
    return kept


def test_pictures_of_the_last_seconds_are_kept_at_intervals_and_the_last_always():
    kept = past(*np.arange(0, 4.01, 0.05))
    times = [p.time / SECOND for p in kept.kept]
    assert times[-1] == 4.0
    assert 2.0 < times[0] < 2.0 + 2 * SPACING
    assert np.diff(times[:-1]).min() >= SPACING
    assert np.diff(times).max() <= SPACING + 0.1
    assert [p.time / SECOND for p in past(0.0, 1.0, 1.5, 1.9).between(SECOND, round(1.9 * SECOND))] == [1.5]


def test_a_kept_picture_has_edges_of_its_own():
    picture = picture_of(perspective(), drawn(perspective(), standing(2.5)))
    kept = PastPicture.kept(0, picture, 1.0).picture
    before = kept.magnitude.copy()
    picture.magnitude[:] = 0
    np.testing.assert_array_equal(kept.magnitude, before)


@pytest.mark.parametrize(("delay", "found"), [(2.5, True), (0.0, False)])
def test_who_is_reported_late_is_followed_from_there_to_the_present(delay, found):
    """The person turned round and walked the other way meanwhile, as no velocity of then could tell."""
    room, ways = FastInstance(maximum_delay=delay), [*np.arange(0, 0.4, 0.06), *np.arange(0.4, -0.7, -0.06)]
    room.tell(standing(2.5, 0.0))
    late, room.told = room.told, None
    for across in ways[:-1]:
        room.see(standing(2.5, across), boxed=None)
    room.told = late
    poses = room.see(standing(2.5, ways[-1]), boxed=None)
    assert bool(abs(poses.xy[0, 1] - ways[-1]) < 0.12) is found
    if found:
        history = room.stage.people[1].history
        assert history.at(SECOND)[1] == pytest.approx(ways[10], abs=0.15)


def test_who_was_reported_before_walks_on_from_there_as_since_then():
    room = FastInstance()
    room.tell(standing(2.5, 0.0))
    room.stage.correct_by_slow_poses(room.told, 0)
    room.stage.people.clear()
    room.told = None
    for _ in range(7):
        room.see(boxed=None)
    room.number = 5
    room.tell(standing(2.5, 0.4))
    room.stage.correct_by_slow_poses(room.told, round(0.7 * SECOND))
    np.testing.assert_allclose(room.stage.people[1].track.velocity, [0.0, 0.8])
