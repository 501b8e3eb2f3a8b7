"""Feet on the floor that one picture shows about them, before anybody knows the room without people."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import BLACK, BLUE, SHIRT, WALL, perspective, standing
from tests.plugins.persons.shown import SlowInstance

from followspot.geometry import project
from followspot_persons.background.body_axis import BEFORE_AXIS
from followspot_persons.background.floor_beside import FLOOR, body_before, contact_beside
from followspot_persons.body.shape import read_shape
from followspot_persons.body.view import view
from followspot_persons.likelihood.fitness import Detection
from followspot_persons.slow_instance.part_box import stood

NOBODY, NONE = np.empty((0, 4)), np.empty(0)
TILES = (150, 160, 170), (110, 118, 125)


def tiled(camera):
    """An empty room: a floor of two colours before a wall, (H, W, 3) u1."""
    pixels = np.full((camera.size[1], camera.size[0], 3), WALL, np.uint8)
    rows, columns = np.indices(pixels.shape[:2])
    floor = rows > 128
    pixels[floor] = np.where(((rows // 6 + columns // 9) % 2)[..., None] == 0, *map(np.uint8, TILES))[floor]
    return pixels


def of_person(*poses, trousers=BLUE):
    """Camera, and a picture of people of these poses on that floor, the nearest one last."""
    camera = perspective()
    pixels = tiled(camera)
    for pose in poses:
        head, waist, foot = project(camera, np.array([[*pose[:2], z] for z in (pose[2], 1.0, 0.0)]))
        near = project(camera, np.array([[pose[0] - BEFORE_AXIS, pose[1], 0.0]]))[0, 1]
        half = 0.08 * (foot[1] - head[1])
        columns = slice(int(head[0] - half), int(head[0] + half))
        pixels[int(head[1]) : int(waist[1]), columns] = SHIRT
        pixels[int(waist[1]) : int(near), columns] = trousers
    return camera, pixels


@pytest.mark.parametrize("seeming", [0.88, 1.0, 1.12])
@pytest.mark.parametrize("distance", [3.2, 3.8, 4.4])
def test_the_floor_about_the_feet_tells_the_distance_that_the_pose_misses(distance, seeming):
    camera, pixels = of_person(standing(distance))
    contact = contact_beside(camera, pixels, standing(seeming * distance, height=1.75), NOBODY)
    assert contact.distance == pytest.approx(distance, abs=0.15)


@pytest.mark.parametrize("share", [0.72, 0.8])
def test_feet_are_seen_of_a_body_that_a_box_took_for_a_third_nearer(share):
    """The floor before the seeming feet is below the picture; a body twice as near is another's."""
    true = standing(4.2)
    camera, pixels = of_person(true)
    assert contact_beside(camera, pixels, seeming(share, true), NOBODY).distance == pytest.approx(
        4.2, abs=0.15
    )
    assert contact_beside(camera, pixels, seeming(0.6, true), NOBODY) is None


def test_feet_are_seen_although_the_floor_before_the_seeming_ones_is_below_the_picture():
    """Feet at 3.0 m, and a pose of the size of 2.45 m: at 2.2 m the floor is below the picture."""
    camera, pixels = of_person(standing(3.0))
    seeming_near = standing(2.45)
    before = project(camera, np.array([[FLOOR * 2.45, 0.0, 0.0]]))[0, 1]
    assert before > camera.size[1] - 2
    assert contact_beside(camera, pixels, seeming_near, NOBODY).distance == pytest.approx(3.0, abs=0.15)
    assert contact_beside(camera, pixels, standing(2.0), NOBODY) is None


def test_no_feet_are_told_where_the_picture_shows_none():
    """Feet below the picture, no person, trousers of the floor's colour, legs behind a nearer person."""
    near, far = standing(1.4), standing(3.5)
    for poses, trousers in (([near], BLUE), ([], BLUE), ([far], TILES[0])):
        camera, pixels = of_person(*poses, trousers=trousers)
        assert contact_beside(camera, pixels, poses[0] if poses else far, NOBODY) is None
    camera, pixels = of_person(far)
    assert contact_beside(camera, pixels, far, view(camera, read_shape(), far[None]).box) is None


def test_furniture_that_hides_feet_is_no_floor():
    """A board stands before the legs from 0.5 m on, as broad as the picture; its edge is 1 m too far away."""
    true = standing(3.5)
    camera, pixels = of_person(true)
    pixels[int(project(camera, np.array([[2.8, 0, 0.3]]))[0, 1]) :] = BLACK
    assert contact_beside(camera, pixels, true, NOBODY) is None


@pytest.mark.parametrize("side", [-1, 1])
def test_a_nearer_person_hides_the_floor_at_one_side_and_no_feet(side):
    """The floor at the other side tells them; it does not if furniture stands there, or at both sides."""
    true = standing(4.0)
    camera, pixels = of_person(true)
    nearer = view(camera, read_shape(), standing(1.8, 0.44 * side)[None]).box
    assert contact_beside(camera, pixels, true, nearer).distance == pytest.approx(4.0, abs=0.15)
    both = view(camera, read_shape(), np.stack([standing(1.8, 0.44), standing(1.8, -0.44)])).box
    assert contact_beside(camera, pixels, true, both) is None
    middle = int(project(camera, true[None, :3])[0, 0])
    away = slice(0, middle - 8) if side == -1 else slice(middle + 8, None)
    pixels[: int(project(camera, np.array([[3.82, 0, 0.02]]))[0, 1]), away] = BLACK
    assert contact_beside(camera, pixels, true, nearer) is None


def test_a_shank_beside_the_middle_is_a_step_and_no_foot():
    """Both shanks go on aside below the knees, where the middle is floor."""
    true = standing(3.0)
    camera, pixels = of_person(true)
    knee, foot = project(camera, np.array([[2.82, 0, 0.4], [2.82, 0, 0.0]]))[:, 1].astype(int)
    pixels[knee:] = tiled(camera)[knee:]
    for row in range(knee - 4, foot):
        for side in (-1, 1):
            pixels[row, 159 + side * (row - knee + 10) + np.arange(-5, 6)] = BLUE
    assert contact_beside(camera, pixels, true, NOBODY) is None


def test_the_floor_tells_feet_while_no_background_is_known():
    """The box is of a tall person farther away."""
    true = standing(3.0)
    camera, pixels = of_person(true)
    box = view(camera, read_shape(), standing(3.5, height=1.78)[None]).box[0]
    told = stood(camera, pixels, None, Detection(box, NONE, NONE), standing(3.5, height=1.78), 1.7, NOBODY)
    assert not told.part
    assert told.contact.distance == pytest.approx(3.0, abs=0.15)
    blind = replace(camera, translation=np.zeros(3))
    assert stood(blind, pixels, None, told.detection, true, 1.7, NOBODY).contact is None


def seeming(share, true):
    """A pose at a share of the true distance whose head's top is in the same place of the picture, (6,)."""
    return standing(share * true[0], share * true[1], 1.2 + share * (true[2] - 1.2))


SMALL = standing(3.0, height=1.45)
HEAD = seeming(2.2, SMALL)
"""As if the head of a small person were an upper body."""


def test_a_body_goes_on_below_the_feet_of_a_head_that_seems_to_be_an_upper_body():
    camera, pixels = of_person(SMALL)
    for share in (1.5, 2.0, 2.5):
        assert body_before(camera, pixels, seeming(share, SMALL), NOBODY)
        assert contact_beside(camera, pixels, seeming(share, SMALL), NOBODY) is None
    for share in (0.85, 1.0, 1.15):
        assert not body_before(camera, pixels, seeming(share, SMALL), NOBODY)


def test_a_belt_of_the_colour_of_the_floor_is_not_below_the_feet_of_a_head():
    camera, pixels = of_person(SMALL)
    row = int(project(camera, np.array([[HEAD[0] - BEFORE_AXIS, 0, 0.0]]))[0, 1])
    pixels[row : row + 6] = tiled(camera)[row : row + 6]
    assert contact_beside(camera, pixels, HEAD, NOBODY) is None


def test_nothing_is_said_where_a_nearer_person_or_no_floor_is():
    camera, pixels = of_person(SMALL)
    nearer = view(camera, read_shape(), standing(1.8)[None]).box
    assert not body_before(camera, pixels, HEAD, nearer)
    assert not body_before(camera, pixels, standing(1.2), NOBODY)
    blind = replace(camera, translation=np.zeros(3))
    assert not body_before(blind, pixels, HEAD, NOBODY)


@pytest.mark.parametrize(("boxed", "numbers"), [(HEAD, []), (SMALL, [1])])
def test_boxes_of_a_head_alone_initiate_nobody_before_there_is_a_background(boxed, numbers):
    show = SlowInstance()
    _, pixels = of_person(SMALL)
    for number in range(5):
        told = show.see_pixels(np.roll(pixels, 2 * (number % 2), axis=1), boxed=[boxed], score=3.0)
    assert told.person.tolist() == numbers


def test_a_person_stands_where_its_feet_are_from_the_first_second_on():
    """Boxes are a sixth too small; a background is known after 2.5 s only."""
    show, true = SlowInstance(), standing(3.0)
    _, pixels = of_person(true)
    for number in range(4):
        shown = np.roll(pixels, 2 * (number % 2), axis=1)
        told = show.see_pixels(shown, boxed=[standing(3.5, height=1.78)], score=3.0)
    assert told.contact[0, 0] == pytest.approx(3.0, abs=0.15)
    assert told.pose[0, 0] == pytest.approx(3.0, abs=0.3)
