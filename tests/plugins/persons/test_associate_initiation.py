"""How soon people whose joints were found get a number."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.plugins.persons.crowded import corner_room

from followspot import Context
from followspot.messages import Header, stamped
from followspot.points import Points2D
from followspot.room import Member
from followspot_persons.associate.joints.agreement import agreement
from followspot_persons.associate.multi_view.views import Noise, images, views_of
from followspot_persons.associate.stage import Associate
from followspot_sim.actor.points import PersonPoints

FPS = 10
VIEWS = views_of(tuple(corner_room().cameras.values()))


def detections(cameras: int, seed: int = 1, **network: Any) -> list[tuple[Points2D, ...]]:
    """What the first cameras find of one person, or of false ones, in each set. network: its mistakes."""
    room, found = corner_room(), []
    for name in list(room.cameras)[:cameras]:
        stage = PersonPoints(
            Context(name, room, Member("cameras", name)),
            people=1,
            frames=30,
            fps=FPS,
            seed=seed,
            walking_area=(-1, -1, 1, 1),
            **network,
        )
        stage.setup()
        found.append([each.points for each in stage.process()])
    return [
        tuple(stamped(replace(one), Header("n", frame, frame * 10**9 // FPS)) for one in each)
        for frame, each in enumerate(zip(*found, strict=True))
    ]


def people(sets: list[tuple[Points2D, ...]]) -> list[int]:
    """Number of people after each set."""
    stage = Associate(Context("associate", corner_room()))
    stage.setup()
    return [len(stage.process(points=one).poses.person) for one in sets]


def only(points: Points2D, joints: int, names: int) -> Points2D:
    """The first joints of a person alone, of a network that knows as many names."""
    kept = points.where(points.label < joints)
    return stamped(replace(kept, labels=points.labels[:names]), points.header)


@pytest.mark.parametrize(("joints", "names", "first"), [(17, 17, 1), (9, 17, 0), (9, 9, 1)])
def test_two_cameras_report_somebody_at_once_if_most_joints_agree(
    joints: int, names: int, first: int
) -> None:
    """Few joints of many may agree by chance, and wait for the next set."""
    sets = detections(2, clutter=0.0, joint_miss=0.0, person_miss=0.0)
    found = people([tuple(only(one, joints, names) for one in each) for each in sets[:3]])
    assert found == [first, 1, 1]


def test_joints_that_disagree_count_against_those_that_agree() -> None:
    rng = np.random.default_rng(1)
    xyz = rng.uniform([-0.3, -0.3, 0.1], [0.3, 0.3, 1.8], (17, 3))
    noise, both = Noise(2.0, 0.03, 0.0), np.arange(2)
    xy = np.array([images(view.projection, xyz)[0] for view in VIEWS.each[:2]])
    assert agreement(VIEWS, both, xy, xyz, noise) == 17
    far = xy.copy()
    far[1, :5] += 60.0
    assert agreement(VIEWS, both, far, xyz, noise) == 12 - 5
    far[1, 5:8] = np.nan  # one camera alone tells nothing of these
    assert agreement(VIEWS, both, far, xyz, noise) == 9 - 5


def test_false_people_of_two_networks_agree_about_too_few_joints() -> None:
    found = [people(detections(2, seed, clutter=5.0, person_miss=1.0)) for seed in range(1, 7)]
    assert np.mean(found) < 0.03
