"""The stages of the paper as published: spheres, mean shift, missing-frame counter, and nothing more."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.plugins.balls.scene import blobs_of, candidates_at, forecast_at, make_room, positions_at

from followspot.cli.main import main
from followspot.context import Context
from followspot.graph.compile import compile_graph
from followspot.messages import Array
from followspot.tracking import LOST, MISSING, TRACKED, Candidates, Forecast, Pairs
from followspot_balls.plain.kalman import Outputs, PlainKalman
from followspot_balls.plain.mean_shift import PlainMeanShift
from followspot_balls.plain.triangulate import PlainTriangulate
from followspot_balls.verify_pairs import VerifyPairs

GRAPH = Path(__file__).parents[3] / "graphs/jin_qian_2008.yaml"
ROOM = make_room()
BALL = (0.2, -0.1, 1.0)
AWAY = (2.0, 2.0, 1.0)
HERE, THERE = (0.0, 0.0, 1.0), (2.0, 0.0, 1.0)
FPS = 30


def pairs_of(places: dict[str, list[tuple[float, float, float]]]) -> Pairs:
    """Pairs of exact blobs; colour blobs are red, infrared blobs may be both targets."""
    stage = VerifyPairs(Context(room=ROOM))
    stage.setup()
    blobs = []
    for name, points in places.items():
        colored = ROOM.cameras[name].kind == "color"
        blobs.append(blobs_of(ROOM.cameras[name], points, [[True, not colored]] * len(points)))
    return stage.process(tuple(blobs))


def candidates(pairs: Pairs, forecast: Forecast | None) -> Candidates:
    stage = PlainTriangulate(Context(room=ROOM))
    stage.setup()
    return stage.process(pairs, forecast)


def lost(forecast: Forecast, target: int) -> Forecast:
    state = forecast.state.copy()
    state[target] = LOST
    return Forecast(**{**vars(forecast), "state": state})


@pytest.mark.parametrize(("distance", "kept"), [(0.22, 6), (0.23, 0)])
def test_candidates_lie_within_the_sphere_of_22_cm(distance: float, kept: int) -> None:
    pairs = pairs_of({n: [BALL] for n in ROOM.cameras})
    away = (BALL[0] + distance, BALL[1], BALL[2])
    assert len(candidates(pairs, forecast_at([away, AWAY])).xyz) == kept


def test_the_sphere_grows_to_twice_the_last_displacement() -> None:
    pairs = pairs_of({n: [BALL] for n in ROOM.cameras})
    still = forecast_at([(BALL[0] + 0.35, BALL[1], BALL[2]), AWAY])
    before = still.before.copy()
    before[0, 0] -= 0.18
    assert len(candidates(pairs, still).xyz) == 0
    assert len(candidates(pairs, Forecast(**{**vars(still), "before": before})).xyz) == 6


def test_an_unlabelled_candidate_inside_one_ball_still_serves_the_ball_beside_it() -> None:
    pairs = pairs_of({"cam1": [BALL], "cam3": [BALL]})
    found = candidates(pairs, forecast_at([BALL, (BALL[0] + 0.17, BALL[1], BALL[2])]))
    assert found.targets.tolist() == [[True, True]]
    assert found.labelled.tolist() == [False]


def test_a_candidate_below_the_floor_is_one_like_others() -> None:
    deep = (0.2, -0.1, -0.3)
    pairs = pairs_of({"cam0": [deep], "cam1": [deep]})
    assert len(candidates(pairs, forecast_at([deep, AWAY])).xyz) == 1


def test_only_pairs_of_a_color_and_an_infrared_camera_are_candidates_of_a_lost_target() -> None:
    pairs = pairs_of({n: [BALL] for n in ROOM.cameras})
    found = candidates(pairs, None)
    assert found.confirmed.all()
    assert len(found.xyz) == 4  # of six pairs one is of colour, one of infrared cameras alone
    known = candidates(pairs, lost(forecast_at([BALL, BALL]), 0))
    assert known.targets[:, 0].tolist() == known.confirmed.tolist()


def fused(found: Candidates, forecast: Forecast | None, **params: float) -> Array:
    return PlainMeanShift(**params).process(found, forecast).xyz


def test_the_centre_starts_at_the_forecast_and_ignores_what_lies_outside_one_sigma() -> None:
    found = candidates_at([(0.0, 0.0, 1.0), (0.004, 0.0, 1.0), (0.012, 0.0, 1.0)])
    assert fused(found, forecast_at([(0.0, 0.0, 1.0)], sigma=0.01))[0] == pytest.approx([0.002, 0.0, 1.0])
    wide = fused(found, forecast_at([(0.0, 0.0, 1.0)], sigma=0.01), bandwidth_scale=2.5)
    assert wide[0] == pytest.approx([0.016 / 3, 0.0, 1.0])
    moving = replace(forecast_at([(0.3, 0.0, 1.0)], sigma=0.01), last=np.array([[0.0, 0.0, 1.0]]))
    assert len(fused(found, moving)) == 0
    back = replace(forecast_at([(0.0, 0.0, 1.0)], sigma=0.01), last=np.array([[0.3, 0.0, 1.0]]))
    assert fused(found, back)[0] == pytest.approx([0.002, 0.0, 1.0])


def test_labelled_candidates_weigh_one_and_unlabelled_ones_less_with_distance() -> None:
    found = candidates_at([(-0.005, 0.0, 1.0), (0.005, 0.0, 1.0)], labelled=[True, False])
    center = fused(found, forecast_at([(0.0, 0.0, 1.0)], sigma=0.02))[0, 0]
    weight = np.exp(-((0.005 - center) ** 2) / 0.02**2)
    assert center == pytest.approx(-0.005 * (1 - weight) / (1 + weight), abs=2e-4)


def test_weights_fall_with_the_epipolar_distance_over_t_ed() -> None:
    found = candidates_at([(0.0, 0.0, 1.0), (0.01, 0.0, 1.0)], epipolar=[0.0, 3.0])
    x = fused(found, forecast_at([(0.0, 0.0, 1.0)], sigma=0.05))[0, 0]
    assert x == pytest.approx(0.01 * np.exp(-0.5) / (1 + np.exp(-0.5)))


def test_an_empty_kernel_gives_no_position() -> None:
    found = candidates_at([(0.1, 0.0, 1.0)])
    assert len(fused(found, forecast_at([(0.0, 0.0, 1.0)], sigma=0.01))) == 0


def test_a_lost_target_is_where_its_candidates_are_densest() -> None:
    found = candidates_at([(1.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.01, 0.0, 1.0)])
    position = PlainMeanShift().process(found, None)
    assert position.xyz[0] == pytest.approx([0.005, 0.0, 1.0])
    assert position.support.tolist() == [2]


def kalman(**params: float) -> PlainKalman:
    stage = PlainKalman(Context(room=ROOM), **params)
    stage.setup()
    return stage


def watch(
    stage: PlainKalman,
    frames: int,
    first: int = 0,
    seen: bool = True,
    place: tuple[float, float, float] = HERE,
    confirmed: bool = True,
) -> list[Outputs]:
    """Frames in which target 0 is measured at rest, or is not."""
    places = {0: place} if seen else {}
    return [stage.process(positions_at(places, (first + i) / FPS, confirmed)) for i in range(frames)]


def test_one_position_with_a_color_infrared_pair_recovers_a_lost_target_at_once() -> None:
    stage = kalman()
    assert watch(stage, 1, confirmed=False)[0].forecast.state.tolist() == [LOST, LOST]
    outputs = watch(stage, 1, first=1)[0]
    assert outputs.forecast.state.tolist() == [TRACKED, LOST]
    assert outputs.tracks.xyz[0] == pytest.approx(HERE)


@pytest.mark.parametrize("frames", [1, 40])
def test_a_target_is_lost_when_its_counter_reads_25_however_long_it_was_tracked(frames: int) -> None:
    stage = kalman()
    watch(stage, frames)
    states = [o.forecast.state[0] for o in watch(stage, 26, first=frames, seen=False)]
    assert states == [MISSING] * 24 + [LOST] * 2


def test_a_position_sets_the_counter_to_zero_and_needs_no_infrared_camera_while_missing() -> None:
    stage = kalman()
    watch(stage, 5)
    watch(stage, 20, first=5, seen=False)
    assert watch(stage, 1, first=25, confirmed=False)[0].forecast.state[0] == TRACKED
    assert watch(stage, 24, first=26, seen=False)[-1].forecast.state[0] == MISSING


def test_a_missing_target_is_sought_at_its_last_position_and_has_none_itself() -> None:
    stage = kalman()
    for i in range(10):
        watch(stage, 1, first=i, place=(0.02 * i, 0.0, 1.0))
    last = stage.motion.xyz[0].copy()
    for outputs in watch(stage, 5, first=10, seen=False):
        assert len(outputs.tracks.target) == 0
        assert outputs.forecast.xyz[0] == pytest.approx(last)
        assert outputs.forecast.last[0] == pytest.approx(last)


def test_the_forecast_moves_with_the_velocity_and_knows_the_last_two_estimates() -> None:
    stage = kalman()
    for i in range(60):
        outputs = watch(stage, 1, first=i, place=(0.02 * i, 0.0, 1.0))[0]
    assert outputs.forecast.xyz[0] == pytest.approx([0.02 * 60, 0.0, 1.0], abs=1e-3)
    assert (outputs.forecast.last - outputs.forecast.before)[0] == pytest.approx([0.02, 0, 0], abs=1e-3)
    assert outputs.tracks.velocity[0] == pytest.approx([0.6, 0, 0], abs=0.01)


def test_a_recovered_target_has_not_travelled_from_where_it_was_lost() -> None:
    stage = kalman()
    watch(stage, 5)
    watch(stage, 30, first=5, seen=False)
    forecast = watch(stage, 1, first=35, place=THERE)[0].forecast
    assert forecast.last[0] == pytest.approx(THERE)
    assert forecast.before[0] == pytest.approx(THERE)


def test_the_forecast_is_for_the_next_frame_at_any_rate() -> None:
    stage = kalman()
    for i in range(40):
        outputs = stage.process(positions_at({0: (0.05 * i, 0.0, 1.0)}, i / 10))
    assert outputs.forecast.period == pytest.approx(0.1)
    assert outputs.forecast.xyz[0] == pytest.approx([0.05 * 40, 0.0, 1.0], abs=2e-3)


def test_the_noise_is_the_constant_one_whatever_the_fusion_says() -> None:
    found = []
    for told in (np.nan, 0.001, 1.0):
        stage = kalman()
        found.append(
            [stage.process(positions_at({0: HERE}, n / FPS, sigma=told)).tracks.sigma for n in range(5)]
        )
    assert found[0][0] == pytest.approx(np.full((1, 3), 0.008))
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])


def test_a_successor_carries_on_where_its_predecessor_stopped() -> None:
    first, second = kalman(), kalman()
    watch(first, 10)
    watch(first, 3, first=10, seen=False)
    second.restore(first.state())
    one, other = (watch(stage, 3, first=13, place=(0.01, 0.0, 1.0))[-1] for stage in (first, second))
    assert one.tracks.xyz.tolist() == other.tracks.xyz.tolist()
    assert one.forecast.covariance.tolist() == other.forecast.covariance.tolist()


def test_the_graph_has_the_constants_of_the_paper() -> None:
    plan = compile_graph(GRAPH)
    found = {(stage.group, key): value for stage in plan.stages for key, value in stage.params.items()}
    assert {
        ("color", "similarity"): 0.8,
        ("near_color", "minimum_search_radius"): 10.0,
        ("near_color", "search_radius_scale"): 1.5,
        ("near_infrared", "minimum_search_radius"): 10.0,
        ("near_infrared", "search_radius_scale"): 1.5,
        ("verify", "maximum_epipolar_distance"): 3.0,
        ("verify", "homography_tolerance"): 3.0,
        ("triangulate", "minimum_search_radius"): 0.225,
        ("triangulate", "search_radius_scale"): 2.0,
        ("fuse", "epipolar_sigma"): 3.0,
        ("fuse", "convergence_distance"): 0.0005,
        ("track", "maximum_missed_frames"): 25,
    }.items() <= found.items()


def test_the_graph_tracks_the_simulated_room(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(GRAPH), "--frames", "40", "--json", "--quiet", "--out", str(tmp_path)]) == 0
    targets = json.loads(capsys.readouterr().out)["targets"]
    assert set(targets) == {"green", "red", "blue"}
    for score in targets.values():
        assert score["coverage"] > 0.95
        assert score["rmse_mm"] < 15


def test_the_graph_of_the_figures_draws_a_film_and_pictures_of_all_cameras(tmp_path: Path) -> None:
    graph = GRAPH.parent / "experiments/drawn.yaml"
    assert main(["run", str(graph), "--frames", "3", "--quiet", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "film/all.mp4").stat().st_size > 1000
    picture = cv2.imread(str(tmp_path / "pictures/all/000002.jpg"))
    assert picture is not None
    assert picture.shape == (480, 960, 3)
    yellow = (picture[..., 1] > 150) & (picture[..., 2] > 180) & (picture[..., 0] < 90)
    assert yellow.any()  # a search region, from the forecast of the frame before
