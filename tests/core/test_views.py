"""Stages that need two views warn of cameras that do not give them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from followspot.plugins.registry import load_stage
from followspot.testing import tiny_room

STAGES = ("balls.verify_pairs", "vision.triangulate", "persons.associate")


def warned(uses: str, cameras: int, moved: float = 0.0) -> list[str]:
    """What is said of so many cameras at one place, the last so many metres beside it."""
    room = tiny_room()
    first, second = room.cameras.values()
    place = first.center + np.array([moved, 0.0, 0.0])
    views = [first, first, first, first, replace(second, translation=-second.rotation @ place)]
    stage = load_stage(uses)
    found = stage.check_room(stage.Params(), room, views[len(views) - cameras :])
    return [mistake.text for mistake in found if mistake.remedy]


@pytest.mark.parametrize("uses", STAGES)
def test_cameras_at_one_place_are_told(uses: str) -> None:
    (text,) = warned(uses, 2)
    assert text.endswith("two cameras at different places, and cam0, cam1 stand at one")
    (text,) = warned(uses, 5)
    assert text.endswith("and cam0, cam0, cam0 and 2 more stand at one")
    assert warned(uses, 2, moved=0.06) == warned(uses, 5, moved=0.06) == []


@pytest.mark.parametrize("uses", STAGES)
def test_a_camera_alone_is_told(uses: str) -> None:
    (text,) = warned(uses, 1)
    assert text.endswith("two cameras, and only camera cam1 sends any")
    assert warned(uses, 0) == [], "a source may send for several cameras"
