"""What all views say of a place where a lost target turns up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import blobs_of, forecast_at, look_at, make_room

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import LOST, MISSING, Blobs, Candidates, Forecast, Positions
from followspot_balls.association.recovery import AGREEING, Recovery, RecoveryParams
from followspot_balls.association.view_params import ViewParams
from followspot_balls.bundle_fusion import Bundle
from followspot_balls.mean_shift import MeanShift
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs
from followspot_target_filter.confirmation import ConfirmationRules, uncertain

BALL, ELSEWHERE = (0.1, 0.2, 1.2), (-1.0, 0.0, 0.5)
OFF = 2.0
"""Distance of a chance blob from the image of the reflector, px: a quarter of the ball."""
Fusion = type[MeanShift] | type[Bundle]
FUSIONS = pytest.mark.parametrize("fusion", [MeanShift, Bundle])


def room_of(kinds: str) -> Room:
    """The small room with a camera for each letter, c or i, all around the middle."""
    angles = 2 * np.pi * np.arange(len(kinds)) / len(kinds)
    cameras = [
        look_at(f"cam{k}", "color" if kind == "c" else "infrared", (3 * np.cos(a), 3 * np.sin(a), 3.0))
        for k, (kind, a) in enumerate(zip(kinds, angles, strict=True))
    ]
    return replace(make_room(), cameras={c.name: c for c in cameras})


def fused(
    fusion: Fusion, room: Room, shown: str, state: Forecast | None = None, off: float = 0.0, **params: float
) -> Positions:
    """The position of the first target that these cameras show, by their numbers; infrared has no label.

    off: px, by which its blobs in colour cameras are too low.
    """
    fuse = fusion(Context(room=room), **params)
    fuse.setup()
    return fuse.process(candidates_of(room, shown, state, off), state)


def candidates_of(room: Room, shown: str, state: Forecast | None, off: float) -> Candidates:
    verify, triangulate = VerifyPairs(Context(room=room)), Triangulate(Context(room=room))
    verify.setup()
    triangulate.setup()
    blobs = tuple(blob(room, name, name[3:] in shown, off) for name in room.cameras)
    return seal(triangulate.process(seal(verify.process(blobs)), state))


def blob(room: Room, name: str, shown: bool, off: float) -> Blobs:
    camera = room.cameras[name]
    found = blobs_of(camera, [BALL] * shown, [[True, camera.kind == "infrared"]] * shown)
    return seal(replace(found, xy=found.xy + np.array([0.0, off]))) if camera.kind == "color" else found


@FUSIONS
def test_a_ball_in_clear_view_keeps_its_support(fusion: Fusion) -> None:
    assert fused(fusion, room_of("cicici"), "012345").support.tolist() == [15]


@FUSIONS
def test_two_views_find_a_ball_that_is_small_in_large_pictures(fusion: Fusion) -> None:
    """Of 28 pixels among 1228800, without any other blob."""
    size, K = (1280, 960), np.array([[960.0, 0.0, 639.5], [0.0, 960.0, 479.5], [0.0, 0.0, 1.0]])
    room = room_of("cccc")
    cameras = {name: replace(room.cameras[name], size=size, matrix=K) for name in ("cam0", "cam1")}
    small = {name: replace(target, radius=0.011) for name, target in room.targets.items()}
    found = fused(fusion, replace(room, cameras=cameras, targets=small), "01")
    assert found.xyz == pytest.approx(np.array([BALL]), abs=1e-3)


@FUSIONS
def test_one_colour_blob_on_the_ray_to_a_reflector_makes_many_pairs_and_no_sure_place(fusion: Fusion) -> None:
    """Four infrared cameras see the reflector, one of five colour cameras has a blob there by chance."""
    found = fused(fusion, room_of("cicicicic"), "01357", off=OFF)
    assert found.support.tolist() == [1]
    assert found.evident.all()
    assert uncertain(found, ConfirmationRules(3, 3, 0.3, 0.0, 0.0, 0)).all(), "so it needs several frames"
    sure = fused(fusion, room_of("cicicicic"), "01357", off=OFF, sure_recovery_evidence=-50.0)
    assert sure.support[0] >= 6


def test_an_unsure_place_that_is_not_evident_counts_as_one_candidate() -> None:
    room = room_of("cicicicic")
    found = fused(MeanShift, room, "01357", off=OFF, sure_recovery_evidence=-50.0)
    found = seal(replace(found, evident=np.zeros(1, bool)))
    judged = Recovery(room, RecoveryParams()).accepted(found, candidates_of(room, "01357", None, OFF), None)
    assert judged.support.tolist() == [1]


def doubted() -> tuple[MeanShift, Candidates]:
    """A fusion, and candidates at an evident place that two frames in a row make sure."""
    room = room_of("cicicici")
    fuse = MeanShift(Context(room=room))
    fuse.setup()
    return fuse, candidates_of(room, "0135", None, 1.5)


def test_frames_in_a_row_that_show_an_evident_place_add_up() -> None:
    fuse, candidates = doubted()
    assert [fuse.process(candidates, None).support.tolist() for _ in range(3)] == [[1], [6], [6]]


def test_what_a_frame_said_fades_so_that_two_that_are_hardly_enough_together_are_not() -> None:
    room = room_of("cicici")
    found, recovery = fused(MeanShift, room, "01"), Recovery(room, RecoveryParams())
    totals = [recovery.accumulated(found, np.array([1.04]), None)[0] for _ in range(3)]
    assert totals[0] == pytest.approx(1.04)
    assert totals[1] < RecoveryParams().sure_recovery_evidence < totals[2]


def test_a_frame_that_does_not_show_the_place_ends_the_row_unless_it_looked_elsewhere() -> None:
    nothing = candidates_of(room_of("cicicici"), "", None, OFF)
    there = forecast_at([BALL, ELSEWHERE])
    missing = seal(replace(there, state=np.full(2, MISSING, np.uint8)))
    for forecast, support in ((None, 1), (there, 1), (missing, 6)):
        fuse, candidates = doubted()
        fuse.process(candidates, None)
        fuse.process(nothing, forecast)
        assert fuse.process(candidates, None).support.tolist() == [support]


def test_another_place_begins_a_row_of_its_own_and_a_checkpoint_goes_on_with_it() -> None:
    fuse, candidates = doubted()
    fuse.process(candidates, None)
    state = fuse.state()
    for off, support in ((0.0, 6), (0.1, 6), (0.2, 1)):
        again, _ = doubted()
        again.restore({**state, "xyz": state["xyz"] + [off, 0.0, 0.0]})
        assert again.process(candidates, None).support.tolist() == [support]


def test_a_place_that_is_hardly_rather_a_ball_than_light_does_not_add_up() -> None:
    """It is rather a ball than a reflector: a blob by chance lies near the ray to it."""
    room = room_of("cicicici")
    fuse = MeanShift(Context(room=room))
    fuse.setup()
    candidates = candidates_of(room, "0135", None, OFF)
    assert [fuse.process(candidates, None).support.tolist() for _ in range(4)] == [[1]] * 4


def test_one_evident_pair_finds_a_target_where_nothing_was_lately() -> None:
    room = room_of("cici")
    usual = candidates_of(room, "01", None, 0.0)
    new = seal(replace(usual, clutter=np.full(usual.clutter.shape, 0.05)))
    found = seal(replace(fused(MeanShift, room, "01"), support=np.ones(1, np.int32)))
    doubtful = seal(replace(found, evident=np.zeros(1, bool), support=np.full(1, 2, np.int32)))
    support = [
        Recovery(room, RecoveryParams()).accepted(position, candidates, None).support.tolist()
        for position, candidates in ((found, usual), (found, new), (doubtful, new))
    ]
    assert support == [[1], [AGREEING], [2]]


@FUSIONS
def test_a_pair_that_most_cameras_contradict_is_no_lost_target(fusion: Fusion) -> None:
    assert not len(fused(fusion, room_of("cici" * 3), "01").target)
    assert len(fused(fusion, room_of("cici" * 3), "01", least_recovery_evidence=-50.0).target)


@FUSIONS
def test_a_pair_that_few_cameras_contradict_may_be_one(fusion: Fusion) -> None:
    found = fused(fusion, room_of("cici"), "01")
    assert found.support.tolist() == [1]
    assert found.evident.all()


@FUSIONS
def test_a_target_that_is_not_lost_needs_no_such_evidence(fusion: Fusion) -> None:
    assert len(fused(fusion, room_of("cici" * 3), "01", forecast_at([BALL, ELSEWHERE])).target) == 1


@FUSIONS
def test_depth_cameras_measure_more_than_views_weigh(fusion: Fusion) -> None:
    room = room_of("cici" * 3)
    depth = replace(room.cameras["cam4"], kind="depth")
    assert len(fused(fusion, replace(room, cameras={**room.cameras, "cam4": depth}), "01").target) == 1


@FUSIONS
def test_an_unlikely_place_is_told_of_lost_targets_alone(fusion: Fusion) -> None:
    there = forecast_at([BALL, ELSEWHERE])
    lost = seal(replace(there, state=np.full(2, LOST, np.uint8)))
    assert not len(fused(fusion, room_of("cici" * 3), "01", lost).target)


def test_a_doubted_place_is_as_vague_as_it_is_unlikely_and_the_others_stay() -> None:
    """An even chance leaves half of a square metre along each axis."""
    room = room_of("cici")
    one = fused(MeanShift, room, "0123")
    found = seal(Positions(**{name: np.repeat(getattr(one, name), 4, axis=0) for name in one.array_names}))
    found = seal(replace(found, evident=np.array([True, False, False, False])))
    weighed, ratio = np.array([True, True, True, False]), np.array([0.0, np.log(3.0), 9.0, np.inf])
    left = Recovery(room, RecoveryParams()).with_support(found, weighed, ratio, ratio)
    added = (left.covariance - found.covariance) @ np.ones(3)
    assert added == pytest.approx(np.array([[0.5] * 3, [0.25] * 3, [0.0] * 3, [0.0] * 3]))
    assert left.support.tolist() == [1, 1, 6, 6]


def ratios(shown: str, place: Array, room: Room) -> Array:
    """Of a ball and against a reflector at a place, of a lost target that these cameras show."""
    candidates = candidates_of(room, shown, None, 0.0)
    return Recovery(room, RecoveryParams()).ratios(place[None], np.zeros(1, int), candidates, None)[:, 0]


def test_a_place_that_does_not_stand_out_is_taken_at_the_likeliest_one_nearby() -> None:
    """Colour cameras alone show it, so that paint explains the views as well, and a reflector does not."""
    room, beside = room_of("cicici"), np.array(BALL) + np.array([0.0, 0.03, 0.02])
    there, near = (ratios("024", place, room) for place in (np.array(BALL), beside))
    assert there[0] < 2.0 < 5.0 < there[1]
    assert near == pytest.approx(there, abs=0.1)


def test_the_place_of_a_lost_target_is_known_to_the_reach_of_a_step() -> None:
    """A reflector that the infrared camera shows lies by chance where the colour ray passes: the probability
    falls with the length of its ray on which it may be.
    """
    room, place = room_of("ci"), np.array(BALL)[None]
    near, far = (Recovery(room, RecoveryParams()) for _ in range(2))
    far.reach = 10 * near.reach
    assert near.reach == ViewParams().reach
    candidates = candidates_of(room, "01", None, 0.0)
    known, unknown = (one.ratios(place, np.zeros(1, int), candidates, None)[1, 0] for one in (near, far))
    assert known - unknown == pytest.approx(np.log(10.0), rel=0.02)
