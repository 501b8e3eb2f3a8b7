"""Depth images as pictures: metres as colours, black where nothing was measured."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from followspot.messages import Header, stamped
from followspot.tracking import DepthImage
from followspot_dashboard.depth_colors import depth_picture, scale_colors
from followspot_dashboard.picture import picture_of


def test_what_was_not_measured_is_black_and_nothing_else_is_nearly_so() -> None:
    depth = np.array([[0.0, np.nan, np.inf, -1.0], [1e-3, 4.0, 8.0, 100.0]])
    picture = depth_picture(depth, 8.0)
    assert not picture[0].any()
    assert (picture[1].max(axis=1) > 100).all()
    assert (picture[1, 2] == picture[1, 3]).all()  # beyond the farthest there is no other colour


def test_near_is_warm_far_is_cold_and_the_scale_says_so() -> None:
    near, middle, far = depth_picture(np.array([[0.2, 4.0, 7.8]]), 8.0)[0].astype(int)
    assert near[2] > 2 * near[0]
    assert far[0] > 1.5 * far[2]
    assert middle[1] == max(middle)
    blue, green, red = depth_picture(np.array([[8.0]]), 8.0)[0, 0].tolist()
    assert scale_colors(9)[-1] == f"#{red:02x}{green:02x}{blue:02x}"
    assert len(set(scale_colors(9))) == 9


def test_a_smaller_preview_invents_no_depth_at_an_edge() -> None:
    """A mean of 1 m and 7 m would have the colour of a surface that is not there."""
    depth = np.where(np.arange(960) % 3 == 0, 1.0, 7.0).astype("f4")
    image = stamped(DepthImage("tof", np.tile(depth, (720, 1))), Header("camera/tof", 4, 5_000_000))
    picture = picture_of(image, 320, farthest=8.0)
    assert picture is not None
    assert (picture.camera, picture.width, picture.height, picture.header.seq) == ("tof", 960, 720, 4)
    pixels = cv2.imdecode(picture.jpeg, cv2.IMREAD_COLOR)
    assert pixels is not None
    assert pixels.shape == (240, 320, 3)
    known = depth_picture(np.array([[1.0, 7.0]]), 8.0)[0].astype(float)
    apart = np.abs(pixels[:, :, None] - known).max(axis=-1).min(axis=-1)
    assert apart.max() < 12  # of JPEG


@pytest.mark.parametrize("size", [(0, 5), (5, 0)])
def test_a_depth_image_without_pixels_has_no_preview(size: tuple[int, int]) -> None:
    assert picture_of(DepthImage("tof", np.zeros(size, "f4")), 320) is None
