"""Balls in infrared pictures (Jin & Qian 2008, sections 2.2 and 3.3)."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.detected import BALLS, FORECAST, HERE, THERE, detector
from tests.plugins.balls.scene import SIZE, forecast_at, make_room, picture
from tests.plugins.balls.two_balls import ROOM, painted

from followspot.context import Context
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.tracking import Forecast, Frame
from followspot_balls.ir_blobs import IrBlobs


@pytest.mark.parametrize("forecast", [None, FORECAST])
def test_ir_blobs_finds_both_balls_and_labels_neither(forecast: Forecast | None) -> None:
    blobs = detector(IrBlobs, "cam1", radius_offset=0.0).process(
        picture(ROOM.cameras["cam1"], BALLS), forecast
    )
    expected = project(ROOM.cameras["cam1"], np.array([HERE, THERE]))
    order = np.argsort(blobs.pixel[:, 1])
    assert blobs.pixel[order] == pytest.approx(expected[np.argsort(expected[:, 1])], abs=0.2)
    assert (blobs.similarity == 1).all()
    if forecast is None:
        assert blobs.targets.all()
    else:
        assert blobs.targets[order].sum(axis=1).tolist() == [1, 1]


def test_an_infrared_blob_in_two_windows_is_one_blob_of_two_targets() -> None:
    near = (HERE[0] + 0.1, HERE[1], HERE[2])
    frame = picture(ROOM.cameras["cam1"], {"red": np.array(HERE)})
    blobs = detector(IrBlobs, "cam1").process(frame, forecast_at([HERE, near]))
    assert blobs.targets.tolist() == [[True, True]]


@pytest.mark.parametrize("camera", ["cam1", "cam3"])
def test_infrared_balls_that_touch_in_a_picture_are_two_blobs(camera: str) -> None:
    beside = (HERE[0] + 0.14, HERE[1], HERE[2])
    places = np.array([HERE, beside])
    frame = picture(ROOM.cameras[camera], dict(zip(("red", "green"), places, strict=True)))
    assert len(detector(IrBlobs, camera).process(frame, None).pixel) == 1
    found = detector(IrBlobs, camera).process(frame, forecast_at([HERE, beside]))
    off = np.linalg.norm(found.pixel[:, None] - project(ROOM.cameras[camera], places), axis=2)
    assert off.min(axis=0) == pytest.approx(np.zeros(2), abs=0.6)


def test_hot_pixels_are_not_balls() -> None:
    frame = painted("cam1", [])
    pixels = frame.pixels.copy()
    pixels[::9, ::9] = 255
    assert len(detector(IrBlobs, "cam1").process(seal(Frame(camera="cam1", pixels=pixels)), None).xy) == 0


@pytest.mark.parametrize("forecast", [None, FORECAST])
@pytest.mark.parametrize(("gray", "seen"), [(99, False), (100, True), (200, True), (201, False)])
def test_grey_levels_out_of_the_range_are_not_seen(gray: int, seen: bool, forecast: Forecast | None) -> None:
    room = make_room()
    for target in room.targets.values():
        target.gray["cam1"] = (100.0, 200.0)  # type: ignore[index]
    stage = IrBlobs(Context.serving(room.cameras["cam1"], room))
    stage.setup()
    column, row = np.rint(project(room.cameras["cam1"], np.array([HERE]))[0]).astype(int)
    pixels = np.zeros((SIZE[1], SIZE[0], 1), np.uint8)
    pixels[row - 2 : row + 4, column - 2 : column + 4] = gray
    assert len(stage.process(seal(Frame(camera="cam1", pixels=pixels)), forecast).xy) == seen
