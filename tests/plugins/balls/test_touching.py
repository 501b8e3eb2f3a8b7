"""Balls side by side in a picture: each has a blob of its own, whose centre is the ball's."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, forecast_at, make_room, picture

from followspot.context import Context
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.color_blobs import ColorBlobs
from followspot_balls.ir_blobs import IrBlobs

ROOM = make_room()
BALL = (0.1, 0.2, 1.2)


def found(places: dict[str, tuple[float, float, float]], forecast: Forecast) -> Blobs:
    """The blobs of an infrared camera, which sees balls there."""
    stage = IrBlobs(Context.serving(ROOM.cameras["cam1"], room=ROOM))
    stage.setup()
    shown = {name: np.array(place) for name, place in places.items()}
    return seal(stage.process(picture(ROOM.cameras["cam1"], shown), forecast))


def beside(gap: float) -> tuple[float, float, float]:
    """A place whose image is so many radii to the right of that of BALL."""
    right = ROOM.cameras["cam1"].rotation[0] * gap * RADIUS
    x, y, z = np.array(BALL) + right
    return (float(x), float(y), float(z))


def off(blobs: Blobs, place: tuple[float, float, float]) -> float:
    """Distance of the nearest blob from the image of a place, px."""
    pixel: Array = project(ROOM.cameras["cam1"], np.array([place]))
    return float(np.linalg.norm(blobs.pixel - pixel, axis=1).min())


@pytest.mark.parametrize("gap", [1.3, 1.6, 2.0])
def test_two_balls_that_touch_are_two_blobs_at_their_places(gap: float) -> None:
    places = {"red": BALL, "green": beside(gap)}
    blobs = found(places, forecast_at(list(places.values())))
    assert len(blobs.xy) == 2
    for place in places.values():
        assert off(blobs, place) < 0.6
    assert blobs.area.max() < 1.2 * blobs.area.min()


def test_a_ball_beside_the_forecast_of_one_that_is_not_there_stays_whole() -> None:
    alone = found({"red": BALL}, forecast_at([BALL, (-1.0, 0.0, 0.5)]))
    blobs = found({"red": BALL}, forecast_at([BALL, beside(1.9)]))
    assert blobs.area.tolist() == alone.area.tolist()
    assert blobs.pixel == pytest.approx(alone.pixel, abs=0.01)


@pytest.mark.parametrize("stage", [ColorBlobs, IrBlobs])
def test_a_quarter_of_a_ball_beside_another_one_shows_where_the_ball_is(
    stage: type[ColorBlobs] | type[IrBlobs],
) -> None:
    camera = ROOM.cameras["cam0" if stage is ColorBlobs else "cam1"]
    other, late = (np.array(BALL) - camera.rotation[0] * length * RADIUS for length in (2.3, 0.3))
    pixels = picture(camera, {"red": np.array(BALL), "green": other}).pixels.copy()
    (pixel,) = project(camera, np.array([BALL]))
    x, y = np.rint(pixel).astype(int)
    pixels[:, x + 1 :] = pixels[y:, x - 2 :] = 0
    finder = stage(Context.serving(camera, room=ROOM))
    finder.setup()
    forecast = forecast_at([tuple(late), tuple(other + late - np.array(BALL))])
    blobs = finder.process(seal(Frame(camera.name, pixels)), forecast)
    assert np.linalg.norm(blobs.pixel - pixel, axis=1).min() < 1.0
