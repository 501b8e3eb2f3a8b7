"""What a network sees of a picture, and where that lies in the picture."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_persons.body.standing import WAIST
from followspot_persons.body.upper_body_box import HIP
from followspot_persons.pose_net.regions import AROUND, LONGEST, about, whole


def ramp(width: int, height: int) -> np.ndarray:
    """A picture whose first channel is the column and second the row."""
    v, u = np.mgrid[:height, :width]
    return np.dstack([u, v, np.full_like(u, 200)]).astype(np.uint8)


@pytest.mark.parametrize("side", [64, 120, 256])
def test_a_place_in_the_image_shows_what_the_picture_has_there(side):
    pixels = ramp(200, 120)
    region = whole(200, 120, side, 32, None)
    image = region.cut(pixels)
    assert image.shape[:2] == (region.size[1], region.size[0])
    place = np.array([[10, 10], [40, 25], [region.filled[0] - 8, region.filled[1] - 8]])
    u, v = region.in_picture(place).T
    seen = image[place[:, 1], place[:, 0]].astype(float)
    assert seen[:, 0] == pytest.approx(u, abs=1)
    assert seen[:, 1] == pytest.approx(v, abs=1)


def test_the_shorter_side_gets_the_size_asked_for_and_sides_are_multiples():
    region = whole(640, 480, 256, 32, None)
    assert (region.filled, region.size) == ((341, 256), (352, 256))
    tall = whole(1080, 1920, 256, 32, None)
    assert (tall.filled, tall.size) == ((256, 455), (256, 480))
    assert (whole(640, 480, 256, 32, None).cut(ramp(640, 480))[:, 341:] == 0).all()


def test_long_pictures_are_bounded_and_tiny_ones_fill_an_image():
    assert max(whole(100_000, 100, 256, 32, None).size) <= LONGEST
    assert whole(1, 1, 64, 32, None).size == (64, 64)


def test_a_model_of_one_size_gets_the_whole_picture_in_it():
    region = whole(640, 480, 1000, 32, (192, 256))
    assert (region.filled, region.size) == ((192, 144), (192, 256))


def test_the_square_about_a_person_is_about_the_hips_and_has_the_body_s_size():
    body = 200.0
    box = np.array([80.0, 40.0, 120.0, 40 + (1 - WAIST) * body])
    region = about(box, (640, 480), (256, 256))
    assert region is not None
    assert region.width == region.height == round(AROUND * body)
    middle = region.left + region.width / 2, region.top + region.height / 2
    assert middle == pytest.approx((100, 40 + (1 - HIP) * body), abs=1)
    image = region.cut(np.full((480, 640, 3), 255, np.uint8))
    assert image.shape == (256, 256, 3)
    assert (image[:, 0] == 0).all()  # beyond the left border
    assert (image[128, 128] == 255).all()


@pytest.mark.parametrize(
    "box",
    [
        [0, 0, 0, 0],
        [0, 0, 10, 1e9],
        [np.nan, 0, 9, 9],
        [0, np.inf, 9, 9],
        [900, 0, 940, 60],
        [0, 1e7, 9, 1e7 + 60],
    ],
)
def test_boxes_that_no_picture_shows_have_no_region(box):
    assert about(np.array(box, float), (640, 480), (256, 256)) is None


def test_fine_patterns_are_averaged_when_a_picture_is_reduced():
    v, u = np.mgrid[:512, :512]
    pixels = np.repeat((255 * ((u + v) % 2))[:, :, None], 3, axis=2).astype(np.uint8)
    image = whole(512, 512, 96, 32, None).cut(pixels)
    assert np.abs(image.astype(int) - 127).max() <= 2
