"""Colours of torsos: histograms, and people who are told apart by their clothes where places tell nothing."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from tests.plugins.persons.crowded import corner_room

from followspot import Context
from followspot.geometry import project
from followspot.messages import Header, stamped
from followspot.points import Points2D
from followspot.tracking import Frame
from followspot_persons.associate.colors import track_colors
from followspot_persons.associate.colors.torso_colors import BINS, histograms, log_ratios, torsos_in
from followspot_persons.associate.stage import Associate

RED, BLUE = (30, 30, 200), (200, 60, 30)
JOINTS = ("nose", "left_shoulder", "right_shoulder", "left_hip", "right_hip")
BODY = np.array([[0.0, 0, 1.6], [0, 0.2, 1.4], [0, -0.2, 1.4], [0, 0.15, 0.95], [0, -0.15, 0.95]])
RATE = 10
PATCH = np.array([[[10, 10], [40, 10], [10, 40], [40, 40]]], float)


def flat(color):
    return np.full((50, 50, 3), color, np.uint8)


def test_equal_clothes_speak_for_one_person_and_others_against() -> None:
    red, blue, grey = (histograms(flat(color), PATCH)[0] for color in (RED, BLUE, (90, 92, 91)))
    assert red.sum() == pytest.approx(1.0)
    assert log_ratios(red, red) > 1
    for other in (blue, grey):
        assert log_ratios(red, other) < -1.5
    light, dark = (histograms(flat((value,) * 3), PATCH)[0] for value in (220, 20))
    assert log_ratios(light, dark) < -1.5


def test_what_is_not_known_says_nothing() -> None:
    outside = histograms(flat(RED), PATCH - [30, 0])
    assert np.isnan(outside).all()
    unknown = histograms(flat(RED), np.full((1, 4, 2), np.nan))
    assert log_ratios(unknown[0], histograms(flat(RED), PATCH)[0]) == 0
    assert histograms(flat(RED), PATCH[:0]).shape == (0, BINS)
    assert not np.isnan(histograms(flat(RED), PATCH - [12, 0])).any()


def test_what_two_patches_share_does_not_count() -> None:
    picture = flat(RED)
    picture[:, 32:] = BLUE
    beside = np.vstack([PATCH, PATCH + np.array([22, 0])])
    found = histograms(picture, beside)
    np.testing.assert_allclose(found[0], histograms(flat(RED), PATCH)[0])
    assert np.isnan(histograms(picture, np.vstack([PATCH, PATCH + np.array([5, 0])]))).all()


def test_the_torso_is_above_the_middle_of_a_box() -> None:
    picture = flat(BLUE)
    picture[5:25, 18:32] = RED
    found = histograms(picture, torsos_in(np.array([[10.0, 0.0, 40.0, 50.0]])))
    np.testing.assert_allclose(found, histograms(flat(RED), PATCH))


def test_a_body_is_compared_with_its_own_camera_and_learnt_in_full_view_only() -> None:
    red, blue = (histograms(flat(color), PATCH) for color in (RED, BLUE))
    known = track_colors.initial_colors(3, np.array([0]), red)
    assert track_colors.color_log_ratios(known, 0, red) > 1
    assert track_colors.color_log_ratios(known, 1, red) > 1  # by the other camera
    there = track_colors.updated_colors(known, np.array([0]), 1, blue, np.array([1.0]))
    assert track_colors.color_log_ratios(there, 1, blue) > 1
    assert track_colors.color_log_ratios(there, 0, blue) < -1.5
    hidden = track_colors.updated_colors(known, np.array([0]), 1, blue, np.array([0.5]))
    np.testing.assert_array_equal(hidden, known)
    again = track_colors.updated_colors(known, np.array([0]), 0, blue, np.array([1.0]))
    assert track_colors.color_log_ratios(again, 0, red) > 0.9  # one picture does not change the mind


def told(room, frame, people):
    """Joints and pictures of people: colour -> place (2,) m."""
    points, frames = [], []
    for camera in room.cameras.values():
        pixels = np.full((camera.size[1], camera.size[0], 3), 128, np.uint8)
        body = np.array([BODY + np.append(place, 0.0) for place in people.values()]).reshape(-1, 3)
        pixel = project(camera, body)
        away = [np.linalg.norm(camera.center[:2] - place) for place in people.values()]
        for row in np.argsort(away)[::-1]:
            outline = np.rint(pixel.reshape(-1, 5, 2)[row, [1, 2, 4, 3]]).astype(np.int32)
            cv2.fillConvexPoly(pixels, outline, list(people)[row])
        count = len(people)
        header = Header("camera", frame, frame * 10**9 // RATE)
        message = Points2D(
            camera=camera.name,
            labels=JOINTS,
            label=np.tile(np.arange(5, dtype=np.int32), count),
            instance=np.repeat(np.arange(count, dtype=np.int32), 5),
            pixel=pixel,
            xy=pixel,
            score=np.ones(5 * count),
        )
        points.append(stamped(message, header))
        frames.append(stamped(Frame(camera.name, pixels), header))
    return points, frames


def numbers_of(colors, after):
    """Numbers of red and blue before they meet unseen, and afterwards, when they are at these places."""
    room = corner_room()
    stage = Associate(Context("associate", room), detection_probability=0.05)
    stage.setup()
    found = {}
    for frame in range(22):
        y = 1.2 - 0.1 * frame
        people = {RED: (0.0, y), BLUE: (0.0, -y)}
        if frame >= 11:
            people = {} if frame < 19 else {RED: (0.0, after), BLUE: (0.0, -after)}
        points, frames = told(room, frame, people)
        out = stage.process(points=points, frames=frames if colors else ())
        for person, xy in zip(out.poses.person, out.poses.xy, strict=True):
            for color, place in people.items():
                if np.linalg.norm(xy - place) < 0.15:
                    found.setdefault(color, []).append(int(person))
    return found


@pytest.mark.parametrize("after", [0.25, -0.25])
def test_who_met_unseen_is_known_again_by_clothes_whichever_way_each_went(after) -> None:
    found = numbers_of(colors=True, after=after)
    assert {len(set(numbers)) for numbers in found.values()} == {1}
    assert found[RED][0] != found[BLUE][0]
    assert len(found[RED]) > 10


def test_without_pictures_one_of_both_ways_is_mistaken() -> None:
    mistaken = [
        any(len(set(numbers)) > 1 for numbers in numbers_of(colors=False, after=after).values())
        for after in (0.25, -0.25)
    ]
    assert sum(mistaken) == 1


@pytest.mark.parametrize("order", [(RED, BLUE), (BLUE, RED)])
def test_two_cameras_pair_people_by_clothes_where_epipolar_lines_allow_both(order) -> None:
    """Two people mirrored at the plane between the cameras: crossed rays meet as well as the right ones."""
    room = corner_room()
    room = replace(room, cameras={name: room.cameras[name] for name in ("c0", "c1")})
    stage = Associate(Context("associate", room))
    stage.setup()
    for frame in range(5):
        points, frames = told(room, frame, {order[0]: (0.6, 0.0), order[1]: (-0.6, 0.0)})
        found = stage.process(points=points, frames=frames).poses
    np.testing.assert_allclose(sorted(found.xy[:, 0]), [-0.6, 0.6], atol=0.05)


def test_pictures_without_joints_give_nothing() -> None:
    room = corner_room()
    stage = Associate(Context("associate", room))
    stage.setup()
    _, frames = told(room, 0, {})
    assert stage.process(frames=frames) is None
