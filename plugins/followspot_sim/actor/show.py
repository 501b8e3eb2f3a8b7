"""Stages `sim.show_camera` and `sim.show_truth`: people in their room, and glowing balls above them."""

from __future__ import annotations

import numpy as np

from followspot import Array, Camera, Field, Room, Source
from followspot.geometry import project
from followspot.tracking import Truth
from followspot_sim.actor.camera import PersonCamera
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.picture import ActorPicture
from followspot_sim.parameters import COLORS
from followspot_sim.performance import Performance
from followspot_sim.rendering.ball_image import color_light, compose, stamps
from followspot_sim.rendering.camera_rays import camera_rays
from followspot_sim.rendering.screen import rays_of
from followspot_sim.sensor import linear


class ShowParams(ActorParams):
    """The people of the simulated room, and the balls above them."""

    ball_circle: float = Field(
        0.8, gt=0, le=5, unit="m", description="radius of the circle on which the balls go around the room"
    )
    ball_height: float = Field(
        1.95, gt=0, le=10, unit="m", description="height of the balls, above the heads of the people"
    )
    ball_period: float = Field(12.0, gt=0.1, unit="s", description="time of one turn")


def ball_places(params: ShowParams, count: int, frame: int) -> Array:
    """Centres of the balls, (count, 3) m: evenly on one circle, each rising and falling by 5 cm."""
    turn = 2 * np.pi * (frame / params.fps / params.ball_period + np.arange(count) / max(count, 1))
    circle = params.ball_circle * np.array([np.cos(turn), np.sin(turn)])
    return np.column_stack([*circle, params.ball_height + 0.05 * np.sin(3 * turn)])


class ShowCamera(PersonCamera):
    """Render people in a lit room, and above them the targets of the room as glowing balls.

    The balls have the colours of their names. Nothing hides them, because they hang above the heads. Every
    instance computes the same performance, so the pictures are consistent in any placement. With `realtime`
    frames come no earlier than their time; none is skipped.
    """

    class Params(ShowParams, PersonCamera.Params):
        """The people, the room and the balls."""

    params: Params

    def setup(self) -> None:
        """Draw the empty room."""
        self._picture = _ShowPicture(self.params, self.room, self.camera)


class ShowTruth(Performance):
    """Give the true positions of the balls of `sim.show_camera`.

    The parameters must equal those of the cameras.
    """

    class Params(ShowParams):
        """The people, the room and the balls."""

    params: Params

    def process(self) -> Source[Truth]:
        """Centres of all balls; trackable are those in the pictures of two cameras or more."""
        names = tuple(self.room.targets)
        for frame in self.frames():
            xyz = ball_places(self.params, len(names), frame)
            views = sum(_inside(camera, xyz).astype(int) for camera in self.room.cameras.values())
            shown = np.asarray(views) >= 2
            yield self.at(frame, Truth(names, xyz, hidden=~shown, trackable=shown, pair=shown))


class _ShowPicture(ActorPicture):
    """One camera's pictures of people and balls."""

    def __init__(self, params: ShowParams, room: Room, camera: Camera) -> None:
        super().__init__(params, camera)
        self._params = params
        self._radii = np.array([target.radius for target in room.targets.values()])
        usual = list(COLORS.values())
        rgb = [COLORS.get(name, usual[k % len(usual)]) for k, name in enumerate(room.targets)]
        self._glow = linear(np.array(rgb, float).reshape(-1, 3)[:, ::-1]).astype(np.float32)
        self._view = camera_rays(camera, rays_of(camera))

    def light(self, frame: int) -> Array:
        """The people and the room, and the balls in front of them."""
        picture = super().light(frame)
        balls = ball_places(self._params, len(self._radii), frame)
        seen = stamps(self._view, project(self.camera, balls), balls, self._radii)
        compose(picture, seen, color_light(seen, self._glow))
        return picture


def _inside(camera: Camera, xyz: Array) -> Array:
    """Which points lie in the picture of a camera, (N,) bool."""
    with np.errstate(invalid="ignore"):
        pixel = project(camera, xyz)
        return np.asarray(((pixel >= 0) & (pixel < np.array(camera.size))).all(axis=1))
