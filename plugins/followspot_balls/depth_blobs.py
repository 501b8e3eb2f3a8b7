"""Balls in a depth image: spheres of their radius before the empty room."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot import Array, Field, InputError, Latest, Stage
from followspot.errors import Mistake
from followspot.tracking import Candidates, DepthImage, Forecast
from followspot_balls.depth.background import foreground, learnt, rendered
from followspot_balls.depth.spheres import Lens, Spheres, spheres
from followspot_balls.detection.search_circles import forecast_images
from followspot_balls.detection.search_spheres import SphereParams, in_search_spheres, search_spheres
from followspot_balls.scene.targets import lost_targets, target_radii

ON_SPHERE = 2.5
"""Largest distance of points from a sphere that they lie on, in sigmas of a depth."""
EVIDENT_RESIDUAL, FOLLOWED_RESIDUAL = 2.25, 3.0
"""Largest RMS residual of an evident sphere and of one at a forecast, likewise."""
FOLLOWED_ONE_SIDED, FOLLOWED_REACH = 0.3, 0.7
"""How much what touches a sphere at a forecast must come from one side, and its largest distance from the
forecast over its radius."""


class DepthBlobs(Stage):
    """Find spheres of the targets' radii near the forecasts, in the whole image for lost targets.

    A depth image shows no colour: a sphere may be any target of its radius that is lost, until
    `balls.gather` says which.
    """

    per_camera = True

    class Params(SphereParams):
        depth_sigma: float = Field(
            0.008, gt=0, unit="m", description="sigma of a measured depth; raising it tolerates noise"
        )
        clearance: float = Field(
            0.05,
            ge=0,
            unit="m",
            description="smallest distance of a target in front of the background; raising it tolerates an "
            "inexact background, but misses small targets on planes",
        )
        learning_frames: int = Field(
            0,
            ge=0,
            unit="frames",
            description="number of frames at the start from which the background is learnt, as the "
            "farthest depth of each pixel; 0: the planes of the room are the background",
        )
        minimum_face: float = Field(
            0.78,
            ge=0,
            le=1,
            unit="1",
            description="smallest measured share of the outline of a sphere that may start a track; "
            "raising it avoids false recoveries, and delays those of partly hidden balls",
        )
        minimum_one_sided: float = Field(
            0.9,
            ge=0,
            le=1,
            unit="1",
            description="how much the things that touch a sphere must come from one side if the sphere is "
            "to start a track; raising it rejects parts of limbs, but also balls that are held with both "
            "hands",
        )

    params: Params

    def setup(self) -> None:
        camera = self.camera
        self.number = list(self.room.cameras).index(camera.name)
        self.shape = (camera.size[1], camera.size[0])
        self.lens = Lens.of(camera)
        self.radii = target_radii(self.room)
        self.frames = 0
        none = np.zeros((0, len(self.radii)), bool)
        self.nothing = Candidates.empty(cameras=tuple(self.room.cameras), targets=none)
        if self.params.learning_frames:
            self.background = np.zeros(self.shape, np.float32)
        else:
            self.background = rendered(self.lens, self.room.planes.values())

    def process(self, image: DepthImage, forecast: Latest[Forecast] = None) -> Candidates:
        if image.depth.shape != self.shape:
            raise InputError([self.wrong_size(image.depth.shape)])
        depth = np.where(np.isfinite(image.depth), image.depth, np.float32(0))
        if self.frames < self.params.learning_frames:
            self.frames += 1
            self.background = learnt(self.background, depth)
            return self.nothing
        there = foreground(depth, self.background, self.params.clearance)
        tolerance = ON_SPHERE * self.params.depth_sigma
        tried = self.sought(there, forecast)
        return self.candidates(
            spheres(depth, there, tried, self.lens, np.unique(self.radii), tolerance), forecast
        )

    def wrong_size(self, shape: tuple[int, ...]) -> Mistake:
        """The mistake of a depth image of another size."""
        width, height = self.camera.size
        text = f"depth images of {shape[1]}x{shape[0]} px, and camera {self.camera.name} has {width}x{height}"
        return Mistake(None, text, "calibrate the camera at the size of its images")

    def sought(self, there: Array, forecast: Forecast | None) -> Array:
        """The part of the foreground near the forecasts, all of it if a target is lost: (H, W) bool."""
        if forecast is None or lost_targets(forecast, len(self.radii)).any():
            return there
        images = forecast_images(self.room, forecast)
        reach = self.reach(forecast) / self.radii + 1
        tried = np.zeros_like(there)
        for (x, y), half in zip(images.center[self.number], images.ball[self.number] * reach, strict=True):
            if np.isfinite(x + y + half):
                left, right = np.clip([x - half, x + half + 1], 0, self.shape[1]).astype(int)
                top, below = np.clip([y - half, y + half + 1], 0, self.shape[0]).astype(int)
                tried[top:below, left:right] = there[top:below, left:right]
        return tried

    def reach(self, forecast: Forecast) -> Array:
        """Radius of each target's search sphere, (T,) m."""
        return search_spheres(forecast, self.params.minimum_search_radius, self.params.search_radius_scale)

    def candidates(self, found: Spheres, forecast: Forecast | None) -> Candidates:
        """One candidate for each sphere that a target may be, with this camera as both of its views."""
        evident = self.evident(found)
        targets = self.targets(found, evident, forecast)
        rows = np.flatnonzero(targets.any(axis=1))
        xyz, evident = found.xyz[rows], evident[rows]
        image = self.camera.projection @ np.column_stack([xyz, np.ones(len(rows))]).T
        return Candidates(
            cameras=tuple(self.room.cameras),
            xyz=xyz,
            view=np.full((len(rows), 2), self.number, np.int32),
            blob=np.repeat(rows[:, None], 2, axis=1).astype(np.int32),
            xy=np.repeat((image[:2] / image[2]).T[:, None], 2, axis=1),
            area=np.repeat(found.area[rows, None], 2, axis=1),
            epipolar=np.zeros(len(rows)),
            labelled=np.zeros(len(rows), bool),
            confirmed=evident,
            evident=evident,
            targets=targets[rows],
            clutter=np.ones((len(rows), 2)),
        )

    def evident(self, found: Spheres) -> Array:
        """Which spheres are hardly hidden and part of nothing larger, and may start a track: (K,) bool."""
        p = self.params
        whole = (found.face >= p.minimum_face) & (found.one_sided >= p.minimum_one_sided)
        return np.asarray(whole & (found.residual <= EVIDENT_RESIDUAL * p.depth_sigma))

    def targets(self, found: Spheres, evident: Array, forecast: Forecast | None) -> Array:
        """Which spheres may be which targets: (K, T) bool.

        A sphere that is not evident must be where the forecast is, so that a ball is followed behind a hand,
        and not replaced by a hand.
        """
        lost = lost_targets(forecast, len(self.radii))
        unlabelled = np.zeros(len(evident), bool)
        targets = in_search_spheres(found.xyz, unlabelled, forecast, self.radii, self.reach)
        targets &= found.radius[:, None] == self.radii
        targets &= ~lost | evident[:, None]
        if forecast is None or lost.all():
            return targets
        offset = found.xyz[:, None] - forecast.xyz
        near = np.vecdot(offset, offset) <= np.square(FOLLOWED_REACH * self.radii)
        ball = (found.residual <= FOLLOWED_RESIDUAL * self.params.depth_sigma) & (
            found.one_sided >= FOLLOWED_ONE_SIDED
        )
        return np.asarray(targets & (evident[:, None] | (near & ball[:, None])))

    def state(self) -> Any:
        return {"frames": self.frames, "background": self.background} if self.params.learning_frames else None

    def restore(self, state: Mapping[str, Any] | None) -> None:
        if state is not None and self.params.learning_frames:
            self.frames, self.background = int(state["frames"]), np.array(state["background"])
