"""People whom two cameras find by boxes: near ones whose feet a picture cuts off, and wrong pairs."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.box_bodies import standing
from tests.plugins.persons.crowded import corner_room

from followspot import Context
from followspot.messages import Header, stamped
from followspot.people import Boxes
from followspot_persons.associate.assignment.contraction import clusters
from followspot_persons.associate.boxes.ellipsoid import boxes_of
from followspot_persons.associate.boxes.standing import stands
from followspot_persons.associate.multi_view.views import views_of
from followspot_persons.associate.stage import Associate

ROOM = corner_room()
VIEWS = views_of(tuple(ROOM.cameras.values()))
FLOOR = ROOM.planes["floor"]
NEAR_FIRST, NEAR_SECOND = (-1.5, -1.5), (1.5, -1.5)
"""Places so near to the first and to the second camera that its picture ends above the feet."""


def found(*xy: tuple[float, float], sets: int = 4) -> np.ndarray:
    """Places of the people, (P, 2) m, after some sets of the first two cameras' exact boxes."""
    stage = Associate(Context("associate", ROOM))
    stage.setup()
    for number in range(sets):
        header = Header("n", number, number * 10**8)
        poses = stage.process(boxes=tuple(stamped(boxes, header) for boxes in both(xy))).poses
    return np.asarray(poses.xy)


def both(xy: tuple[tuple[float, float], ...]) -> list[Boxes]:
    """The boxes of people of usual height in the first two cameras' pictures, which cut some off."""
    return boxes_in(standing(*xy).state[:, 0])


def boxes_in(bodies: np.ndarray) -> list[Boxes]:
    """The boxes of bodies (P, 10) in the first two cameras' pictures."""
    sent = []
    for name, view in zip(list(ROOM.cameras)[:2], VIEWS.each, strict=False):
        box, _ = boxes_of(view, bodies)
        box = np.clip(box, 0.0, np.tile(np.array(ROOM.cameras[name].size) - 1.0, 2))
        none = np.zeros((len(box), 0))
        sent.append(Boxes(name, box, np.ones(len(box)), none, none))
    return sent


def test_two_pairs_count_more_than_one_better_pair_of_different_people() -> None:
    ratio = np.full((4, 4), -np.inf)  # 0 and 2 show one person, 1 and 3 another
    for a, b, value in ((0, 3, 5.0), (0, 2, 4.0), (1, 3, 3.0)):
        ratio[a, b] = ratio[b, a] = value
    assert [rows.tolist() for rows in clusters(ratio)] == [[0, 2], [1, 3]]
    assert [rows.tolist() for rows in clusters(ratio, least_gain=2.5)] == [[0, 3]]  # among many false ones
    ratio[1, 3] = ratio[3, 1] = 1.5
    assert [rows.tolist() for rows in clusters(ratio)] == [[0, 3]]


def test_the_surest_pair_stays_if_others_make_no_more_people() -> None:
    ratio = np.full((4, 4), -np.inf)
    for a, b, value in ((0, 2, 9.0), (1, 3, 0.5), (0, 3, 6.0), (1, 2, 6.0)):
        ratio[a, b] = ratio[b, a] = value
    assert [rows.tolist() for rows in clusters(ratio)] == [[0, 2], [1, 3]]


@pytest.mark.parametrize("height", [1.5, 1.95])
def test_small_and_tall_people_are_found(height: float) -> None:
    bodies = standing((0.3, 2.0))
    bodies.state[..., 2], bodies.state[..., 7] = height / 2, np.log(height / 2)
    stage = Associate(Context("associate", ROOM))
    stage.setup()
    for number in range(3):
        header = Header("n", number, number * 10**8)
        places = stage.process(
            boxes=tuple(stamped(one, header) for one in boxes_in(bodies.state[:, 0]))
        ).poses.xy
    np.testing.assert_allclose(places, [(0.3, 2.0)], atol=0.15)


@pytest.mark.parametrize("xy", [NEAR_FIRST, NEAR_SECOND])
def test_a_person_whose_feet_one_picture_cuts_off_is_found(xy: tuple[float, float]) -> None:
    boxes = both((xy,))
    assert sum(one.box[0, 3] >= 959 for one in boxes) == 1
    np.testing.assert_allclose(found(xy), [xy], atol=0.15)


def test_two_people_near_one_camera_each_are_two() -> None:
    places = found(NEAR_FIRST, NEAR_SECOND)
    np.testing.assert_allclose(places[np.argsort(places[:, 0])], [NEAR_FIRST, NEAR_SECOND], atol=0.15)


@pytest.mark.parametrize(
    ("upper", "lower", "possible"),
    [(1.75, None, True), (None, 0.1, True), (1.1, None, False), (None, 0.8, False), (1.75, 0.0, False)],
)
def test_one_end_alone_is_a_persons_only_at_the_height_of_head_or_feet(
    upper: float | None, lower: float | None, possible: bool
) -> None:
    """Of two ends others decide, by their distance."""
    ends = np.array([[[1.0, 1.0, np.nan if z is None else z] for z in (upper, lower)]])
    assert stands(ends, FLOOR).tolist() == [possible]
