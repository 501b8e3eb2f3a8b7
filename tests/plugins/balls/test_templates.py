"""Templates of targets, learnt from clips of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tests.plugins.balls.scene import learn_color
from tests.plugins.balls.two_balls import painted

from followspot.messages import Array
from followspot_balls.templates.from_clip import learn_infrared


def clip(camera: str, color: tuple[int, int, int], seen: Array) -> list[Array]:
    """A disc that moves; with a hot pixel, and frames in which it is out of view."""
    frames = []
    for i, visible in enumerate(seen):
        discs = [(20.0 + 5 * i, 50.0, 2.5 + 0.1 * i, color)] if visible else []
        pixels = painted(camera, discs).pixels.copy()
        pixels[5, 5] = 255
        frames.append(pixels)
    return frames


def test_a_template_is_learnt_from_a_lone_ball() -> None:
    seen = np.arange(20) % 5 != 0
    histogram, area = learn_color(clip("cam0", (0, 0, 255), seen))
    assert histogram == pytest.approx(np.eye(16)[0])
    assert np.pi * 2.4**2 < area[0] < np.pi * 3.2**2
    assert np.pi * 4.0**2 < area[1] < np.pi * 5.0**2
    gray, area = learn_infrared(clip("cam1", (180, 180, 180), seen))
    assert 60 < gray[0] < 120
    assert gray[1] == 180
    assert area[0] < 30 < 50 < area[1]


@pytest.mark.parametrize("learn", [learn_color, learn_infrared])
def test_a_clip_without_a_ball_says_why(learn: Callable[..., object]) -> None:
    with pytest.raises(ValueError, match="no frames"):
        learn([])
    dark = clip("cam0", (0, 0, 0), np.zeros(20, bool))
    with pytest.raises(ValueError, match=r"moves|moving"):
        learn(dark)


def test_a_colourless_spot_is_no_colour_template() -> None:
    with pytest.raises(ValueError, match="no colour"):
        learn_color(clip("cam0", (255, 255, 255), np.ones(20, bool)))
