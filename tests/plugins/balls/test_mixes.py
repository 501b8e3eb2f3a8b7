"""The ball tracker in rooms with any mix of cameras: cut from the simulated room."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.plugins.balls.scene import blobs_of, forecast_at, make_room, positions_at

import followspot as fs
from bench.balls.camera_mixes import Mix, first_positions, part
from followspot import room_file
from followspot.context import Context
from followspot.errors import InputError
from followspot.tracking import LOST, MISSING, TRACKED, Pairs
from followspot_balls.kalman import Kalman
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs

GRAPHS = Path(__file__).parents[3] / "graphs"
GRAPH = GRAPHS / "glowballs.yaml"
FRAMES = 60


# Bars: what hides a ball from one of two cameras ends its measurements, so two cover less than three.
@pytest.mark.parametrize(
    ("color", "infrared", "targets", "told", "coverage"),
    [
        pytest.param(3, 0, 3, False, 0.9, marks=pytest.mark.thorough),
        (2, 0, 3, False, 0.6),
        (0, 3, 3, True, 0.9),
        (0, 2, 1, False, 0.6),
        (1, 1, 3, False, 0.6),
    ],
)
def test_balls_are_tracked_by_any_mix_of_cameras(
    tmp_path: Path, color: int, infrared: int, targets: int, told: bool, coverage: float
) -> None:
    simulated = room_file.load(GRAPHS / "rooms/simulated.yaml")
    room = part(simulated, Mix(color, infrared, targets), seed=7, frames=FRAMES)
    room_file.save(room, tmp_path / "room.yaml")
    settings = {"track.marks": first_positions(room)} if told else {}
    with fs.run(GRAPH, room=tmp_path / "room.yaml", set=settings, out=tmp_path) as run:
        found = {row["target"]: row for row in run.wait().accuracy}
    assert len(found) == targets
    for name, row in found.items():
        assert row["coverage"] > coverage, name
        assert row["rmse_mm"] < 25, name
        assert row["identity_switches"] == 0, name


RED, GREEN = (0.0, 0.0, 1.0), (0.5, 0.3, 1.2)


def pairs_of(*cameras: str, stage: VerifyPairs | None = None) -> Pairs:
    """The pairs of red, which the cameras show where it is."""
    if stage is None:
        stage = VerifyPairs(Context(room=make_room()))
        stage.setup()
    room = stage.room
    return stage.process(tuple(blobs_of(room.cameras[name], [RED], [[True, False]]) for name in cameras))


def test_pairs_of_one_kind_are_evidence_where_no_other_kind_sends() -> None:
    assert pairs_of("cam0", "cam2").evident.tolist() == [True]
    assert pairs_of("cam1", "cam3").confirmed.tolist() == [True]
    both = pairs_of("cam0", "cam1", "cam2")
    assert both.confirmed.tolist() == [True, False, True]  # not the pair of cam0 and cam2


@pytest.mark.parametrize(
    ("params", "kinds"),
    [({}, [0, 1, 2]), ({"color_color": False}, [0, 1]), ({"infrared_infrared": False}, [1, 2])],
)
def test_pairs_of_one_kind_can_be_left_out(params: dict[str, bool], kinds: list[int]) -> None:
    stage = VerifyPairs(Context(room=make_room()), **params)
    stage.setup()
    pairs = pairs_of("cam0", "cam1", "cam2", "cam3", stage=stage)
    color = np.array([camera.kind == "color" for camera in stage.room.cameras.values()])
    assert sorted(set(color[pairs.view].sum(axis=1).tolist())) == kinds


def test_a_camera_that_falls_silent_does_not_weaken_the_evidence() -> None:
    stage = VerifyPairs(Context(room=make_room()))
    stage.setup()
    pairs_of("cam0", "cam1", "cam2", stage=stage)
    assert not pairs_of("cam0", "cam2", stage=stage).confirmed.any()
    successor = VerifyPairs(Context(room=make_room()))
    successor.setup()
    successor.restore(stage.state())
    assert not pairs_of("cam0", "cam2", stage=successor).confirmed.any()


def test_sure_light_is_no_evidence_for_colour_cameras_alone() -> None:
    stage = VerifyPairs(Context(room=make_room()))
    stage.setup()
    spot, sunk, ball = (0.3, 0.2, 0.0), (0.3, 0.2, 0.04), (0.3, 0.2, 0.0762)
    for place, kept in ((spot, 0), (sunk, 1), (ball, 1)):
        blobs = [blobs_of(stage.room.cameras[n], [place], [[True, False]]) for n in ("cam0", "cam2")]
        assert len(stage.process(tuple(blobs)).xy) == kept


def nameless_pairs(target: list[bool]) -> Pairs:
    """What two infrared cameras show of a ball that may be any of these targets."""
    stage = VerifyPairs(Context(room=make_room()))
    stage.setup()
    return stage.process(tuple(blobs_of(stage.room.cameras[n], [GREEN], [target]) for n in ("cam1", "cam3")))


def test_what_no_colour_tells_apart_is_a_lost_target_only_if_all_others_are_tracked() -> None:
    stage = Triangulate(Context(room=make_room()))
    stage.setup()
    pairs = nameless_pairs([True, True])
    assert not stage.process(pairs).targets.any()
    forecast = forecast_at([RED, GREEN])
    last = replace(forecast, state=np.array([TRACKED, LOST], np.uint8))
    assert stage.process(pairs, last).targets.tolist() == [[False, True]]
    near = replace(forecast, state=np.array([LOST, MISSING], np.uint8))
    assert stage.process(pairs, near).targets.tolist() == [[False, True]]


def test_a_marked_target_is_found_at_its_mark() -> None:
    stage = Kalman(Context(room=make_room()), marks={"green": GREEN})
    stage.setup()
    forecast = stage.process(positions_at({}, 0)).forecast
    assert forecast.state.tolist() == [LOST, MISSING]
    assert forecast.xyz[1] == pytest.approx(GREEN)
    assert not stage.tracks().target.size
    place = (0.55, 0.3, 1.2)
    outputs = stage.process(positions_at({1: place}, 1 / 30))
    assert outputs.tracks.target.tolist() == [1]
    assert outputs.tracks.xyz[0] == pytest.approx(place)
    assert outputs.tracks.velocity[0] == pytest.approx([0, 0, 0])


def test_the_only_target_that_is_not_tracked_is_sought_everywhere_in_spite_of_its_mark() -> None:
    stage = Kalman(Context(room=make_room()), marks={"green": GREEN})
    stage.setup()
    outputs = stage.process(positions_at({0: RED}, 0))
    assert outputs.forecast.state.tolist() == [TRACKED, LOST]


def warned(folder: Path, mix: Mix, **settings: object) -> list[str]:
    """What `check` says of the demo graph in such a room."""
    room = part(room_file.load(GRAPHS / "rooms/simulated.yaml"), mix, seed=7, frames=FRAMES)
    room_file.save(room, folder / "room.yaml")
    return [mistake.text for mistake in fs.check(GRAPH, room=folder / "room.yaml", set=settings)]


def test_rooms_in_which_nothing_can_be_found_are_warned_about(tmp_path: Path) -> None:
    assert warned(tmp_path, Mix(3, 0)) == warned(tmp_path, Mix(0, 2, 1)) == []
    (alone,) = warned(tmp_path, Mix(1, 0))
    assert alone == "a pair needs blobs of two cameras, and only camera cam0 sends any"
    (untold,) = warned(tmp_path, Mix(0, 2))
    assert untold == "no camera sees colours, so nothing tells green, red, blue apart, and none is found"
    assert (
        warned(tmp_path, Mix(0, 2), **{"track.marks": dict.fromkeys(("green", "red", "blue"), GREEN)}) == []
    )


def without_infrared() -> str:
    """A graph whose infrared cameras send no blobs."""
    return (
        f"graph: mine\nroom: {GRAPHS}/rooms/simulated.yaml\nextends: {GRAPH}\nstages:\n  infrared: null\n"
        "  verify: {in: {blobs: color}}\n  bridge: {in: {blobs: color}}\n"
    )


def test_a_graph_that_leaves_out_a_kind_of_camera_is_warned_about(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(without_infrared())
    (silent,) = (m for m in fs.check(tmp_path / "mine.yaml") if "send no blobs" in m.text)
    assert silent.text == "cam1, cam3, cam4 of the room send no blobs, and count as cameras that see no ball"
    assert silent.remedy == "leave them out of the room: cameras=['cam0', 'cam2', 'cam5']"


@pytest.mark.parametrize("cameras", ["cam0,cam2,cam5", "cam1,cam3,cam4"])
def test_a_sub_graph_of_one_kind_of_camera_tracks_like_a_room_of_these_alone(
    tmp_path: Path, cameras: str
) -> None:
    room = tmp_path / "room.yaml"
    room_file.save(part(room_file.load(GRAPHS / "rooms/simulated.yaml"), Mix(3, 3, 1), 7, FRAMES), room)
    balls = f"{{graph: {GRAPH}, cameras: 'cameras[name={cameras.replace(',', '|')}]'}}"
    (tmp_path / "mine.yaml").write_text(f"graph: mine\nroom: room.yaml\nstages:\n  balls: {balls}\n")
    assert not [m for m in fs.check(tmp_path / "mine.yaml") if "send no blobs" in m.text]
    with fs.run(tmp_path / "mine.yaml", out=tmp_path / "mine") as run:
        run.wait()
    with fs.run(GRAPH, room=room, cameras=cameras.split(","), out=tmp_path / "alone") as run:
        run.wait()
    alone = (tmp_path / "alone/tracks.csv").read_bytes()
    assert alone.count(b"\n") > FRAMES / 2
    assert (tmp_path / "mine/tracks.csv").read_bytes() == alone


def test_pairs_of_a_part_of_the_room_are_triangulated_in_the_whole() -> None:
    known = pairs_of("cam1", "cam3")
    room, names = make_room(), ("cam1", "cam3")
    whole, some = Triangulate(Context(room=room)), VerifyPairs(Context(room=room.with_cameras(names)))
    for stage in (whole, some):
        stage.setup()
    partly = some.process(tuple(blobs_of(room.cameras[n], [RED], [[True, False]]) for n in names))
    assert partly.cameras == names != known.cameras
    forecast = forecast_at([RED, GREEN])
    found, expected = whole.process(partly, forecast), whole.process(known, forecast)
    assert found.xyz == pytest.approx(expected.xyz)
    assert len(expected.xyz) == 1
    np.testing.assert_array_equal(found.view, expected.view)


def test_a_target_without_a_template_in_any_camera_is_warned_about(tmp_path: Path) -> None:
    room = part(room_file.load(GRAPHS / "rooms/simulated.yaml"), Mix(2, 1), seed=7, frames=FRAMES)
    red = replace(room.targets["red"], hue_histogram={})
    room_file.save(replace(room, targets={**room.targets, "red": red}), tmp_path / "room.yaml")
    (mistake,) = fs.check(GRAPH, room=tmp_path / "room.yaml")
    assert mistake.text == 'target "red" has no template in any colour camera (cam0, cam2), so none finds it'


def test_targets_of_one_colour_are_warned_about(tmp_path: Path) -> None:
    room = part(room_file.load(GRAPHS / "rooms/simulated.yaml"), Mix(2, 1), seed=7, frames=FRAMES)
    red = room.targets["red"].hue_histogram

    def alike(*names: str, camera: str = "") -> list[str]:
        """What is said if these have the hues of red, all but in one camera."""
        targets = dict(room.targets)
        for name in names:
            own = {key: hues for key, hues in targets[name].hue_histogram.items() if key == camera}
            targets[name] = replace(targets[name], hue_histogram={**red, **own})
        room_file.save(replace(room, targets=targets), tmp_path / "room.yaml")
        return [mistake.text for mistake in fs.check(GRAPH, room=tmp_path / "room.yaml")]

    assert alike() == alike("blue", camera="cam2") == []
    (text,) = alike("blue")
    assert text == 'target "blue" has the colour of "red" in all cameras, so one is taken for the other'
    assert [text.split('"')[1::2] for text in alike("blue", "green")] == [["red", "green"], ["blue", "green"]]


def test_a_mark_of_no_target_is_refused() -> None:
    with pytest.raises(InputError, match='no target "gren"'):
        Kalman(Context(room=make_room()), marks={"gren": GREEN}).setup()


@pytest.mark.parametrize("fusion", ["balls.mean_shift", "balls.bundle"])
def test_targets_that_all_views_contradict_are_told_with_the_parameter(tmp_path: Path, fusion: str) -> None:
    (tmp_path / "mine.yaml").write_text(without_infrared())
    with fs.run(tmp_path / "mine.yaml", set={"fuse.uses": fusion}, frames=30, out=tmp_path) as run:
        report = run.wait()
    (told,) = (text for text in report.warnings if "least_recovery_evidence" in text)
    assert 'never found, though pairs of blobs were evidence: "green" (30 frames), "red"' in told
    (silence,) = (one for one in report.silences if "fuse" in str(one))
    assert "all views contradict the pairs" in silence.advice
