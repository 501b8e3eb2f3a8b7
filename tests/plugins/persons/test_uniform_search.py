"""People are found without a detector before a plain wall: particles everywhere, and some anew."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.drawn import drawn, frame_of, gradients_of, perspective, ready, standing
from tests.travelled import travelled

from followspot.geometry import project
from followspot.messages import identical, stamped
from followspot_persons.appearance import Appearance
from followspot_persons.body.shape import read_shape
from followspot_persons.body.view import view
from followspot_persons.uniform_search import UniformSearch, maxima, separate, shared, uniform_poses

CAMERA = perspective()
NEAR, FAR = standing(2.4, 0.5), standing(3.0, -0.6)


def rng():
    return np.random.default_rng(5)


def pictures(search, count, *poses, first=0):
    """What the search says of pictures, ten a second, of these bodies."""
    return [
        search.process(frame_of(CAMERA, drawn(CAMERA, *poses), n / 10, n))
        for n in range(first, first + count)
    ]


def middles(boxes):
    return sorted(boxes.box[:, [0, 2]].mean(axis=1).tolist())


def expected(*poses):
    return sorted(view(CAMERA, read_shape(), np.stack(poses)).box[:, [0, 2]].mean(axis=1).tolist())


def test_particles_begin_everywhere_that_the_picture_shows():
    poses = uniform_poses(CAMERA, 4000, 6.0, rng())
    pixel = project(CAMERA, np.column_stack([poses[:, :2], np.full(4000, 1.2)]))
    columns = np.histogram(pixel[:, 0], 8, (-0.5, 319.5))[0]
    assert columns.min() > 400
    distance = np.hypot(*poses[:, :2].T)
    assert np.histogram(distance, 6, (0.6, 6.0))[0].min() > 550
    assert np.histogram(poses[:, 3], 8, (-np.pi, np.pi))[0].min() > 400


def test_two_people_are_found_without_a_detector_and_a_plain_wall_has_none():
    search = ready(UniformSearch, CAMERA, particles=800, minimum_likelihood=0.65)
    found = pictures(search, 8, FAR, NEAR)[-1]
    assert middles(found) == pytest.approx(expected(FAR, NEAR), abs=5)
    assert (found.score > 0).all()
    assert len(pictures(search, 1, first=8)[0].box) == 0


def test_a_successor_searches_on():
    first, second = (ready(UniformSearch, CAMERA, particles=200) for _ in range(2))
    pictures(first, 3, FAR)
    second.restore(travelled(first.state()))
    second.rng.bit_generator.state = first.rng.bit_generator.state
    told, expected = (pictures(search, 1, FAR, first=3)[0] for search in (second, first))
    assert identical(told, expected)


def test_random_particles_find_who_comes_later():
    came = {}
    for share in (0.0, 0.5):
        search = ready(UniformSearch, CAMERA, particles=800, minimum_likelihood=0.65, random_share=share)
        pictures(search, 6, NEAR)
        came[share] = len(pictures(search, 8, FAR, NEAR, first=6)[-1].box)
    assert came == {0.0: 1, 0.5: 2}


def test_the_slow_instance_confirms_whom_the_search_has_found():
    search = ready(UniformSearch, CAMERA, particles=800, minimum_likelihood=0.65)
    slow = ready(Appearance, CAMERA, particles=60)
    for number in range(8):
        swaying = np.roll(drawn(CAMERA, NEAR), 2 * (number % 2), axis=1)
        frame = frame_of(CAMERA, swaying, number / 10, number)
        boxes = stamped(search.process(frame), frame.header)
        told = slow.process(frame, gradients_of(CAMERA, frame), boxes)
    assert told.person.tolist() == [1]
    assert told.pose[0, :2] == pytest.approx(NEAR[:2], abs=0.5)


def test_no_maximum_takes_the_weight_of_another():
    pose = np.zeros((60, 6))
    pose[40:, 0] = 3.0
    weight = shared(pose, np.where(np.arange(60) < 40, 0.0, -10.0))
    assert weight[:40].sum() == pytest.approx(0.5)
    assert weight.sum() == pytest.approx(1)


def test_pictures_of_another_size_are_not_searched_and_it_says_so_once(caplog):
    search = ready(UniformSearch, CAMERA, particles=100)
    for number in range(2):
        frame = frame_of(CAMERA, np.zeros((20, 30, 3), np.uint8), number / 10, number)
        assert len(search.process(frame).box) == 0
    assert [record.levelname for record in caplog.records] == ["WARNING"]


def test_maxima_are_apart_and_the_best_first():
    pose = np.zeros((4, 6))
    pose[:, 0] = 0.0, 0.3, 2.0, 4.0
    assert maxima(pose, np.array([0.7, 0.9, 0.8, 0.2]), 0.5) == [1, 2]


def test_one_outline_at_two_distances_is_one_box_also_across_the_seam():
    box = np.array([[100.0, 50, 140, 150], [105, 60, 135, 130], [300, 50, 340, 150], [-20, 50, 20, 150]])
    assert separate(box, 0) == [0, 2, 3]
    assert separate(box, 320) == [0, 2]
