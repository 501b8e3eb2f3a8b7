"""Pairs of blobs over views, and which of them are projections (Jin & Qian 2008, section 3.4)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from followspot import Array, Camera, Field, Joined, Latest, Mistake, Room, Stage, StageParams
from followspot.geometry import epipolar_distance, transfer
from followspot.tracking import Blobs, Forecast, Pairs
from followspot.two_views import check_two_views
from followspot_balls.pairs.blob_pairs import (
    GatheredBlobs,
    NearPairs,
    candidate_pairs,
    common_targets,
    homography_test,
)
from followspot_balls.pairs.clutter_map import ClutterMap
from followspot_balls.pairs.lying_targets import LyingTargets
from followspot_balls.pairs.silent_kinds import check_kinds
from followspot_balls.pairs.time_alignment import aligned, delays
from followspot_balls.pairs.two_view_geometry import fundamental_stack, homography_stack
from followspot_balls.scene.targets import lost_targets

SURE = 0.4
"""Part of `homography_tolerance` within which a pair is surely light: a ball that lies on a plane fits the
plane less exactly, because its centre is a radius above it."""


class VerifyPairs(Stage):
    """Pair blobs of different cameras; reject pairs off their epipolar lines and projections on planes.

    A pair is evidence of a ball if it joins a colour and an infrared camera. If all cameras that send are of
    one kind, every pair is. An infrared camera shows that a ball, and not light, lies on a plane. Without
    infrared cameras nothing shows this, so the stage then rejects only pairs that are surely light. While a
    target is lost, the stage learns how often each view shows blobs at each place; pairs state this density
    of clutter around their blobs, over the usual density.
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
            description="largest distance at which a pair fits a plane; 0: no test; raising it rejects more "
            "projections, and balls close to the plane",
        )
        minimum_alignment_radius: float = Field(
            10.0,
            gt=0,
            unit="px",
            description="smallest radius around a target's image within which blobs of unsynchronised "
            "cameras are moved along with the target; raising it survives jumps",
        )

        resting_clearance: float = Field(
            0.03,
            ge=0,
            unit="m",
            description="largest clearance above a plane of a target that lies on the plane and is not lost; "
            "a pair in its images is no projection; 0: no target lies on a plane; raising it keeps more "
            "pairs",
        )
        clutter_memory: float = Field(
            120.0,
            gt=0,
            unit="frames",
            description="time after which a blob that a view showed while a target was lost counts for 1/e "
            "as clutter; raising it suits lamps and reflectors that stay",
        )
        color_color: bool = Field(True, description="whether to give pairs of two colour cameras")
        infrared_infrared: bool = Field(
            True, description="whether to give pairs of two infrared cameras, which tell no target"
        )

    params: Params

    @classmethod
    def check_room(cls, params: Params, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Warn if fewer than two cameras send blobs, all stand at one place, or one kind is silent."""
        yield from check_two_views(cameras, "a pair needs blobs of")
        yield from check_kinds(room, cameras)

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
        self.nothing = Pairs.empty(cameras=self.cameras, targets=no_targets)

    def process(self, blobs: Joined[Blobs], forecast: Latest[Forecast] = None) -> Pairs:
        if not blobs:
            return self.nothing
        frame = self.gathered(blobs, forecast)
        near = self.near_epipolar_lines(frame)
        off_plane = self.off_plane(near.order, near.ends)
        keep = self.no_projections(near, off_plane, frame, forecast)
        light = self.sure_light(near, off_plane, keep, len(frame.view))
        if not (self.params.color_color and self.params.infrared_infrared):
            keep &= self.of_wanted_kinds(near.color)
        return self.pairs(frame, near.where(keep), light)

    def gathered(self, blobs: Sequence[Blobs], forecast: Forecast | None) -> GatheredBlobs:
        """The blobs of all cameras at one moment, with the clutter around them, which is learnt."""
        counts = [len(b.xy) for b in blobs]
        number = np.array([self.number[b.camera] for b in blobs], np.intp)
        self.heard[number] = True
        view = number.repeat(counts)
        row = np.arange(len(view)) - (np.cumsum(counts) - counts).repeat(counts)
        xy = np.concatenate([b.xy for b in blobs])
        area = np.concatenate([b.area for b in blobs])
        targets = np.concatenate([b.targets for b in blobs])
        # Clutter stays where a picture shows it, so it is learnt before the blobs move with their targets.
        clutter = self.clutter_around(number, view, xy, targets, forecast)
        if forecast is not None and self.seen_apart(blobs):
            xy = self.at_one_moment(xy, view, targets, blobs, forecast)
        return GatheredBlobs(view, row, xy, area, targets, clutter, self.both_kinds())

    def near_epipolar_lines(self, frame: GatheredBlobs) -> NearPairs:
        """The pairs of blobs of different cameras that lie near their epipolar lines."""
        pair = candidate_pairs(frame.view, frame.targets)
        cameras, ends = frame.view.take(pair), frame.xy.take(pair, axis=0)
        order = cameras[:, 0] * len(self.cameras) + cameras[:, 1]
        distance = epipolar_distance(self.fundamental.take(order, axis=0), ends[:, 0], ends[:, 1])
        near = (distance < self.params.maximum_epipolar_distance).nonzero()[0]
        cameras = cameras.take(near, axis=0)
        return NearPairs(
            pair=pair.take(near, axis=0),
            cameras=cameras,
            ends=ends.take(near, axis=0),
            distance=distance.take(near),
            order=order.take(near),
            color=self.color.take(cameras),
        )

    def no_projections(
        self, near: NearPairs, off_plane: Array, frame: GatheredBlobs, forecast: Forecast | None
    ) -> Array:
        """Which pairs are no projections on planes, or show a ball that lies on one: (M,) bool."""
        part = 1.0 if frame.both_kinds else SURE
        flat = off_plane < part * self.params.homography_tolerance
        keep = homography_test(near.pair, near.color, flat, len(frame.view))
        doubt = (~keep).nonzero()[0]
        if len(doubt) and self.lying.clearance and forecast is not None and len(forecast.state):
            pair, cameras, ends = (a.take(doubt, axis=0) for a in (near.pair, near.cameras, near.ends))
            keep[doubt] = self.lying.shown(ends, cameras, common_targets(frame.targets, pair), forecast)
        return keep

    def sure_light(self, near: NearPairs, off_plane: Array, keep: Array, blobs: int) -> Array:
        """Which of all blobs are light for sure, by a pair that is a projection: (N,) bool."""
        light = np.zeros(blobs, bool)
        if np.count_nonzero(keep) < keep.size:
            sure = off_plane.min(axis=0, initial=np.inf) < SURE * self.params.homography_tolerance
            light[near.pair[~keep & sure]] = True
        return light

    def of_wanted_kinds(self, color: Array) -> Array:
        """Which pairs are of the kinds of cameras that the parameters ask for: (M, 2) bool -> (M,) bool."""
        wanted = np.ones(len(color), bool)
        if not self.params.color_color:
            wanted &= ~color.all(axis=1)
        if not self.params.infrared_infrared:
            wanted &= color.any(axis=1)
        return wanted

    def pairs(self, frame: GatheredBlobs, near: NearPairs, light: Array) -> Pairs:
        """The message with these pairs and their evidence. light: (N,) bool."""
        pair, color = near.pair, near.color
        dark = ~(light.take(pair[:, 0]) | light.take(pair[:, 1]))
        confirmed = color[:, 0] != color[:, 1] if frame.both_kinds else dark
        return Pairs(
            cameras=self.cameras,
            view=near.cameras.astype(np.int32),
            blob=frame.row.take(pair).astype(np.int32),
            xy=near.ends,
            area=frame.area.take(pair),
            epipolar=near.distance,
            labelled=color[:, 0] | color[:, 1],
            confirmed=confirmed,
            evident=confirmed & dark,
            targets=common_targets(frame.targets, pair),
            clutter=frame.clutter.take(pair),
        )

    def clutter_around(
        self, sending: Array, view: Array, xy: Array, targets: Array, forecast: Forecast | None
    ) -> Array:
        """Share of the usual clutter around N blobs: (N,), 1 if no target is lost."""
        lost = lost_targets(forecast, targets.shape[1])
        share = self.clutter.share(view, xy, targets, lost) if np.count_nonzero(lost) else np.ones(len(view))
        self.clutter.learn(sending, view, xy, targets, lost)
        return share

    def both_kinds(self) -> bool:
        """Whether cameras of both kinds have sent blobs, so that pairs of one kind prove nothing."""
        color = self.color[self.heard]
        return bool(0 < np.count_nonzero(color) < len(color))

    def state(self) -> Any:
        return {"heard": self.heard, "clutter": self.clutter.state()}

    def restore(self, state: Any) -> None:
        self.heard = np.array(state["heard"], bool)
        self.clutter.restore(state["clutter"])

    def seen_apart(self, blobs: Sequence[Blobs]) -> bool:
        """Whether the cameras took their pictures at different times."""
        return self.unsynchronised or len({b.header.time for b in blobs}) > 1

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
