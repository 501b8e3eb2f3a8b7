"""Pairs of blobs over views, and which of them are projections (Jin & Qian 2008, section 3.4)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from followspot import Array, Camera, Field, Joined, Latest, Mistake, Room, Stage, StageParams
from followspot.geometry import epipolar_distance, fundamental_matrix, plane_homography, transfer
from followspot.tracking import Blobs, Forecast, Pairs
from followspot_balls.alignment import aligned, delays
from followspot_balls.clutter_map import ClutterMap
from followspot_balls.lying import LyingTargets
from followspot_balls.search import lost_targets
from followspot_balls.strip import row_and_column

SURE = 0.4
"""Part of the homography test's distance up to which a pair is light for sure: a ball that lies on a plane,
its centre a radius above it, satisfies the plane less exactly."""


class VerifyPairs(Stage):
    """Pair blobs of different cameras; reject pairs off their epipolar lines and projections on planes.

    The evidence of a ball is what the cameras that send can give: pairs of a colour and an infrared camera;
    any pair if all are of one kind. Without infrared cameras nothing excuses a ball that lies on a plane, so
    only sure light is rejected then. While a target is lost, the stage learns where each view shows blobs,
    and pairs bear the share of the usual clutter around their blobs.
    """

    advice = (
        "two cameras must see a target at once: check calibration and clocks (`followspot calibrate check`, "
        "`followspot calibrate clocks`), or raise maximum_epipolar_distance"
    )

    class Params(StageParams):
        maximum_epipolar_distance: float = Field(
            3.0,
            gt=0,
            unit="px",
            description="largest distance from the epipolar line; raising it tolerates bad calibration",
        )
        homography_tolerance: float = Field(
            3.0,
            ge=0,
            unit="px",
            description="distance up to which a pair fits a plane; 0: no test; raising it rejects more "
            "projections, and balls close to the plane",
        )
        minimum_alignment_radius: float = Field(
            10.0,
            gt=0,
            unit="px",
            description="smallest distance from a target's image up to which blobs of unsynchronised "
            "cameras move with the target; raising it survives jumps",
        )

        resting_clearance: float = Field(
            0.03,
            ge=0,
            unit="m",
            description="clearance up to which a target that is not lost lies on a plane, where a pair in "
            "its images is no projection; 0: never; raising it keeps more pairs",
        )
        clutter_memory: float = Field(
            120.0,
            gt=0,
            unit="frames",
            description="time after which what a view showed while a target was lost counts for 1/e as "
            "clutter; raising it suits lamps and reflectors that stay",
        )
        color_color: bool = Field(True, description="whether to give pairs of two colour cameras")
        infrared_infrared: bool = Field(
            True, description="whether to give pairs of two infrared cameras, which bear no label"
        )

    params: Params

    @classmethod
    def check_room(cls, params: Params, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Warn if fewer than two cameras send blobs."""
        if len(cameras) < 2:
            sent = f"only camera {cameras[0].name} sends" if cameras else "no camera sends"
            yield Mistake(
                None, f"a pair needs blobs of two cameras, and {sent} any", "add a calibrated camera"
            )

    def setup(self) -> None:
        self.cameras = tuple(self.room.cameras)
        self.number = {name: i for i, name in enumerate(self.cameras)}
        self.clock_offset = np.array([c.clock_offset for c in self.room.cameras.values()])
        self.unsynchronised = bool(self.clock_offset.any())
        self.P = np.array([c.projection for c in self.room.cameras.values()]).reshape(-1, 3, 4)
        self.color = np.array([c.kind == "color" for c in self.room.cameras.values()], bool)
        self.fundamental = fundamental_stack(self.room).reshape(-1, 3, 3)
        planes, orders = len(self.room.planes), len(self.cameras) ** 2
        self.homography = homography_stack(self.room).reshape(planes, orders, 3, 3)
        self.lying = LyingTargets(self.room, self.params.resting_clearance)
        self.heard = np.zeros(len(self.cameras), bool)
        self.clutter = ClutterMap(self.room, self.params.clutter_memory)
        no_targets = np.zeros((0, len(self.room.targets)), bool)
        self.nothing = replace(Pairs.empty(), cameras=self.cameras, targets=no_targets)

    def process(self, blobs: Joined[Blobs], forecast: Latest[Forecast] = None) -> Pairs:
        if not blobs:
            return self.nothing
        counts = [len(b.xy) for b in blobs]
        number = np.array([self.number[b.camera] for b in blobs], np.intp)
        self.heard[number] = True
        view = number.repeat(counts)
        row = np.concatenate([np.arange(count) for count in counts])
        xy = np.concatenate([b.xy for b in blobs])
        area = np.concatenate([b.area for b in blobs])
        targets = np.concatenate([b.targets for b in blobs])
        clutter = self.clutter_around(number, view, xy, targets, forecast)
        if forecast is not None and self.seen_apart(blobs):
            xy = self.at_one_moment(xy, view, targets, blobs, forecast)
        pair = candidate_pairs(view, targets)
        cameras, ends = view.take(pair), xy.take(pair, axis=0)
        order = cameras[:, 0] * len(self.cameras) + cameras[:, 1]
        distance = epipolar_distance(self.fundamental.take(order, axis=0), ends[:, 0], ends[:, 1])
        near = (distance < self.params.maximum_epipolar_distance).nonzero()[0]
        pair, cameras, ends = (a.take(near, axis=0) for a in (pair, cameras, ends))
        color = self.color.take(cameras)
        off_plane = self.off_plane(order.take(near), ends)
        both, sure_distance = self.both_kinds(), SURE * self.params.homography_tolerance
        flat = off_plane < (self.params.homography_tolerance if both else sure_distance)
        keep = homography_test(pair, color, flat, len(view))
        if forecast is not None and len(forecast.state) and self.lying.clearance and not keep.all():
            doubt = (~keep).nonzero()[0]
            mine = targets.take(pair[doubt, 0], axis=0) & targets.take(pair[doubt, 1], axis=0)
            keep[doubt] = self.lying.shown(ends[doubt], cameras[doubt], mine, forecast)
        light = np.zeros(len(view), bool)
        if not keep.all():
            sure = off_plane.min(axis=0, initial=np.inf) < sure_distance
            light[pair[~keep & sure]] = True
        if not self.params.color_color:
            keep &= ~color.all(axis=1)
        if not self.params.infrared_infrared:
            keep &= color.any(axis=1)
        rows = keep.nonzero()[0]
        pair, color = pair.take(rows, axis=0), color.take(rows, axis=0)
        dark = ~(light.take(pair[:, 0]) | light.take(pair[:, 1]))
        confirmed = color[:, 0] != color[:, 1] if both else dark
        return Pairs(
            cameras=self.cameras,
            view=cameras.take(rows, axis=0).astype(np.int32),
            blob=row.take(pair).astype(np.int32),
            xy=ends.take(rows, axis=0),
            area=area.take(pair),
            epipolar=distance.take(near).take(rows),
            labelled=color[:, 0] | color[:, 1],
            confirmed=confirmed,
            evident=confirmed & dark,
            targets=targets.take(pair[:, 0], axis=0) & targets.take(pair[:, 1], axis=0),
            clutter=clutter.take(pair),
        )

    def clutter_around(
        self, sending: Array, view: Array, xy: Array, targets: Array, forecast: Forecast | None
    ) -> Array:
        """Share of the usual clutter around N blobs: (N,), 1 if no target is lost."""
        lost = lost_targets(forecast, targets.shape[1])
        share = self.clutter.share(view, xy, targets, lost) if lost.any() else np.ones(len(view))
        self.clutter.learn(sending, view, xy, targets, lost)
        return share

    def both_kinds(self) -> bool:
        """Whether cameras of both kinds have sent blobs, so that pairs of one kind prove nothing."""
        color = self.color[self.heard]
        return bool(color.any() and not color.all())

    def state(self) -> Any:
        return {"heard": self.heard, "clutter": self.clutter.state()}

    def restore(self, state: Any) -> None:
        self.heard = np.array(state["heard"], bool)
        self.clutter.restore(state["clutter"])

    def seen_apart(self, blobs: Sequence[Blobs]) -> bool:
        """Whether the cameras took their pictures at different times."""
        first = blobs[0].header.time
        return self.unsynchronised or any(b.header.time != first for b in blobs)

    def at_one_moment(
        self, xy: Array, view: Array, targets: Array, blobs: Sequence[Blobs], forecast: Forecast
    ) -> Array:
        """The blobs (N, 2) px corrected to the time of the joined messages."""
        numbers = [self.number[b.camera] for b in blobs]
        delay = np.zeros(len(self.cameras))
        delay[numbers] = delays(blobs, self.clock_offset[numbers])
        return aligned(xy, view, targets, delay, self.P, forecast, self.params.minimum_alignment_radius)

    def off_plane(self, order: Array, ends: Array) -> Array:
        """Homography error of pairs for each plane: (planes, M) px.

        order: (M,) of the two cameras, among all ordered pairs of them; ends: (M, 2, 2) px.
        """
        offset = transfer(self.homography.take(order, axis=1), ends[:, 0]) - ends[:, 1]
        return np.asarray(np.hypot(offset[..., 0], offset[..., 1]))


def candidate_pairs(view: Array, targets: Array) -> Array:
    """All pairs of blobs in different views that may belong to one target: (M, 2), the first view lower.

    view: (N,) ascending; targets: (N, T) bool.
    """
    weights = targets.astype(np.float32)
    common = (weights @ weights.T > 0) & (view[:, None] < view)
    return np.array(row_and_column(common.reshape(-1).nonzero()[0], len(view))).T


def homography_test(pair: Array, color: Array, on_plane: Array, blobs: int) -> Array:
    """Which pairs are no projections.

    A pair on a plane is one, unless a colour blob of it is in list B of that plane: the colour blobs
    of colour-infrared pairs that satisfy the plane too, for an infrared camera sees no projection, so
    there the ball itself lies on the plane.
    pair: (M, 2) numbers of blobs, of `blobs`; color: (M, 2) bool; on_plane: (planes, M) bool. Returns (M,).
    """
    both = color[:, 0] & color[:, 1]
    listed = np.zeros((len(on_plane), blobs), bool)
    plane, row = (on_plane & (color[:, 0] != color[:, 1])).nonzero()
    listed[plane, pair.take(row, axis=0)[color.take(row, axis=0)]] = True
    excused = listed.take(pair[:, 0], axis=1) | listed.take(pair[:, 1], axis=1)
    return np.asarray(~((on_plane & ~excused).any(axis=0) & both))


def fundamental_stack(room: Room) -> Array:
    """Fundamental matrices of all ordered pairs of cameras: (C, C, 3, 3); zero for a camera with itself."""
    P = [camera.projection for camera in room.cameras.values()]
    stack = np.zeros((len(P), len(P), 3, 3))
    for i, j in _ordered_pairs(P):
        stack[i, j] = fundamental_matrix(P[i], P[j])
    return stack


def homography_stack(room: Room) -> Array:
    """Homographies over each plane for all ordered pairs of cameras: (planes, C, C, 3, 3)."""
    cameras = list(room.cameras.values())
    stack = np.zeros((len(room.planes), len(cameras), len(cameras), 3, 3))
    for number, plane in enumerate(room.planes.values()):
        for i, j in _ordered_pairs(cameras):
            stack[number, i, j] = plane_homography(cameras[i], cameras[j], plane)
    return stack


def _ordered_pairs(items: Sequence[object]) -> list[tuple[int, int]]:
    return [(i, j) for i in range(len(items)) for j in range(len(items)) if i != j]
