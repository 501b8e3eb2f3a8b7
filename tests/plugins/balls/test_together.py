"""Cameras that are searched together give what each gives alone, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests.plugins.balls.scene import BGR, SIZE, disc, forecast_at, look_at, make_room, picture

from followspot.context import Context
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.messages import Array, identical
from followspot.room import Camera, Room
from followspot.tracking import LOST, Forecast, Frame
from followspot_balls.color_blobs import ColorBlobs
from followspot_balls.detection.components import MOST
from followspot_balls.detection.search_circles import Circles
from followspot_balls.detection.touching_balls import within_reach
from followspot_balls.ir_blobs import IrBlobs


def three_of_a_kind(kind: str) -> Room:
    """The small room with another camera nearby, where balls look larger, and all of one kind."""
    room = make_room()
    cameras = [*room.cameras.values(), look_at("near", "color", (1.0, 1.0, 1.5))]
    for target in room.targets.values():
        for column in (target.hue_histogram, target.area, target.gray):
            column["near"] = column["cam0"]  # type: ignore[index]
    chosen = {c.name: c for c in cameras if c.kind == kind or c.name == "near"}
    return Room(room.name, chosen, room.planes, room.targets)


COLOR, INFRARED = three_of_a_kind("color"), three_of_a_kind("infrared")


def crowded(camera: Camera, places: Array, rng: np.random.Generator) -> Frame:
    """Balls, half hidden or beside light of their colour, among spots and noise."""
    pixels = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    for center in rng.uniform(0, SIZE, (12, 2)):
        color = tuple(int(level) for level in rng.integers(0, 256, 3))
        disc(pixels, center, float(rng.uniform(0.5, 9.0)), color)  # type: ignore[arg-type]
    for center, color in zip(project(camera, places), (BGR["red"], BGR["green"]), strict=True):
        disc(pixels, center + rng.normal(0, 1.5, 2), float(rng.uniform(2.0, 6.0)), color)
        pixels[:, int(np.clip(center[0] + rng.integers(1, 9), 0, SIZE[0])) :][:, :3] = 0
    bright = np.maximum(pixels, (rng.random(pixels.shape) > 0.995) * np.uint8(255))
    return seal(Frame(camera.name, bright if camera.kind == "color" else bright.max(axis=2, keepdims=True)))


def looked_for(places: Array, rng: np.random.Generator) -> Forecast:
    """Forecasts near the balls, at rest or not, some lost, some out of view."""
    near = places + rng.normal(0, 0.03, places.shape)
    near[rng.random(len(near)) < 0.1] += 30.0
    forecast = forecast_at([tuple(place) for place in near])
    state = np.where(rng.random(len(near)) < 0.3, LOST, forecast.state).astype(np.uint8)
    before = near + rng.normal(0, 0.1, near.shape)
    return seal(Forecast(**{**vars(forecast), "state": state, "before": before}))


@pytest.mark.parametrize(("kind", "room"), [(ColorBlobs, COLOR), (IrBlobs, INFRARED)])
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), same=st.booleans())
@example(seed=804361, same=False)
def test_together_is_what_each_gives_alone(
    kind: type[ColorBlobs | IrBlobs], room: Room, seed: int, same: bool
) -> None:
    rng = np.random.default_rng(seed)
    places = rng.uniform([-0.5, -0.5, 0.6], [0.5, 0.5, 1.4], (2, 3))
    forecast = looked_for(places, rng)
    stages, inputs = [], []
    for camera in room.cameras.values():
        stages.append(kind(Context.serving(camera, room)))
        stages[-1].setup()
        inputs.append((crowded(camera, places, rng), forecast if same else looked_for(places, rng)))
    alone = [seal(stage.process(*given)) for stage, given in zip(stages, inputs, strict=True)]
    for number in (2, 3):
        for order in (slice(number), slice(number - 1, None, -1)):
            together = kind.process_together(stages[order], inputs[order])  # type: ignore[arg-type]
            assert all(identical(seal(a), b) for a, b in zip(together, alone[order], strict=True))


def test_balls_that_touch_are_divided_as_they_are_alone() -> None:
    places = {"red": np.array([0.1, 0.2, 1.2]), "green": np.array([0.1, 0.28, 1.2])}
    near, apart = [(0.1, 0.2, 1.2), (0.1, 0.28, 1.2)], [(0.1, 0.2, 1.2), (-0.4, 0.3, 0.8)]
    stages = [IrBlobs(Context.serving(camera, INFRARED)) for camera in INFRARED.cameras.values()]
    for stage in stages:
        stage.setup()
    inputs = [(picture(stage.camera, places), forecast_at(near)) for stage in stages]
    inputs[0] = (inputs[0][0], forecast_at(apart))
    alone = [seal(stage.process(*given)) for stage, given in zip(stages, inputs, strict=True)]
    assert max(len(blobs.pixel) for blobs in alone[1:]) == 2
    for order in (slice(None), slice(None, None, -1)):
        together = IrBlobs.process_together(stages[order], inputs[order])
        assert all(identical(seal(a), b) for a, b in zip(together, alone[order], strict=True))


@pytest.mark.parametrize("count", range(2, 7))
def test_all_balls_of_a_row_are_within_reach_of_what_shows_them_and_a_distant_one_is_not(count: int) -> None:
    radius = 4.0
    row = np.column_stack([2 * radius * np.arange(count), np.zeros(count)])
    middle = row.mean(axis=0)
    center = np.vstack([row, middle + np.array([0.0, 8 * radius])])[None]
    ball = np.full((1, count + 1), radius)
    circles = Circles(center, ball, ball, ball > np.inf, ball > np.inf)
    near = within_reach(middle[None], np.array([count * np.pi * radius**2]), circles)
    assert near.tolist() == [[True] * count + [False]]


@pytest.mark.parametrize("forecast", [None, forecast_at([(0.1, 0.0, 1.0), (-0.4, 0.3, 0.8)])])
def test_noise_of_one_camera_leaves_the_others_their_blobs(forecast: Forecast | None) -> None:
    places = np.array([(0.1, 0.0, 1.0), (-0.4, 0.3, 0.8)])
    noisy = np.zeros((SIZE[1], SIZE[0], 1), np.uint8)
    for shift in range(3):
        noisy[shift::6, :-2:6] = noisy[shift::6, 1:-2:6] = noisy[shift::6, 2:-1:6] = 255
    stages = [IrBlobs(Context.serving(c, INFRARED), maximum_area=9.0) for c in INFRARED.cameras.values()]
    for stage in stages:
        stage.setup()
    frames = [crowded(stage.camera, places, np.random.default_rng(1)) for stage in stages]
    frames[0] = seal(Frame(stages[0].camera.name, noisy))
    alone = [seal(stage.process(frame, forecast)) for stage, frame in zip(stages, frames, strict=True)]
    together = IrBlobs.process_together(stages, [(frame, forecast) for frame in frames])
    assert all(identical(seal(a), b) for a, b in zip(together, alone, strict=True))
    if forecast is None:
        assert len(alone[0].pixel) == MOST
