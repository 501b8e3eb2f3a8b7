"""The simulated inertial sensor agrees with the path and the orientation of its ball."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from followspot import Context, InputError, Member, room_file
from followspot.inertial import Inertial, PosedTruth
from followspot.rotation import angle_between, from_rotation_vector, multiply, turned
from followspot_sim.imu.stage import SimImu
from followspot_sim.imu.truth import PosedSimTruth
from followspot_sim.world import GRAVITY

ROOM = room_file.load(Path(__file__).parents[3] / "graphs/rooms/simulated_imu.yaml")
SEED = 7
EXACT = {
    f"{name}_{error}": 0.0 for name in ("turn", "force", "field") for error in ("noise", "bias_sigma")
} | {"force_limit": 1e4}


def imu(sensor: str = "imu_red", **params: object) -> SimImu:
    context = Context("imu", ROOM, Member("sensors", sensor))
    stage = SimImu(context, **{"seed": SEED, "frames": 240, **params})
    stage.setup()
    return stage


def readings(stage: SimImu) -> Inertial:
    """All readings as one message."""
    sent = list(stage.process())
    columns = {n: np.concatenate([getattr(m, n) for m in sent]) for n in sent[0].array_names}
    return Inertial(sensor=sent[0].sensor, **columns)


def truths(frames: int = 240) -> list[PosedTruth]:
    stage = PosedSimTruth(Context("truth", ROOM), seed=SEED, frames=frames)
    stage.setup()
    return list(stage.process())


def truth_of(name: str, frames: int = 240) -> tuple[np.ndarray, np.ndarray]:
    """Centre (F, 3) m and orientation (F, 4) of a ball."""
    found = truths(frames)
    rows = [truth.objects.index(name) for truth in found]
    xyz = np.array([truth.xyz[row] for truth, row in zip(found, rows, strict=True)])
    return xyz, np.array([truth.quaternion[row] for truth, row in zip(found, rows, strict=True)])


@pytest.mark.parametrize("rate", [180.0, 1020.0])
def test_the_turn_rates_lead_from_orientation_to_orientation(rate: float) -> None:
    stage = imu(rate=rate, **EXACT)
    found = readings(stage)
    _, q = truth_of("red")
    last = round(200 / 60 * rate)
    here = stage._mount.orientation(0, 1, -0.5)[0]
    for omega in found.turn_rate[:last]:
        here = multiply(here, from_rotation_vector(omega / rate))
    assert angle_between(here, stage._mount.orientation(last, 1, -0.5)[0]) < 1e-9
    assert angle_between(stage._mount.orientation(last, 1)[0], q[200]) < 1e-9


def test_the_specific_forces_lead_along_the_path() -> None:
    rate, lever = 480.0, np.array([0.03, -0.02, 0.05])
    stage = imu(rate=rate, lever_arm=tuple(lever), **EXACT)
    found = readings(stage)
    xyz, q = truth_of("red")
    place = xyz + turned(q, lever)
    to_room = stage._mount.orientation(0, len(found.time))
    acceleration = turned(to_room, found.specific_force) + GRAVITY
    velocity = np.cumsum(acceleration, axis=0) / rate
    path = np.cumsum(velocity, axis=0) / rate
    frame = np.arange(0, 240, 3)
    sensed = path[(frame * 8).clip(1) - 1]
    line = np.column_stack([np.ones(len(frame)), frame])  # where it was and how fast, nothing more
    missing = place[frame] - sensed
    left = missing - line @ np.linalg.lstsq(line, missing, rcond=None)[0]
    assert np.abs(place[frame] - place[0]).max() > 0.5
    assert np.linalg.norm(left, axis=1).max() < 0.03


def test_a_ball_that_lies_feels_its_weight_and_one_that_flies_feels_nothing() -> None:
    still = {"turn_rate": 0.0, "lever_arm": (0.0, 0.0, 0.0)}
    found = readings(imu(frames=1200, seed=7, **still, **EXACT))
    size = np.linalg.norm(found.specific_force, axis=1)
    assert np.isclose(size, 9.81, atol=1e-6).mean() > 0.02
    assert (size < 1e-6).mean() > 0.002
    assert not found.turn_rate.any()


def test_the_field_is_that_of_the_room_in_axes_of_the_ball() -> None:
    field = np.array([5.0, 17.0, -41.0])
    stage = imu(field=tuple(field), **EXACT)
    found = readings(stage)
    assert np.allclose(turned(stage._mount.orientation(0, len(found.time)), found.field), field)
    assert np.isnan(readings(imu(magnetometer=False)).field).all()


def test_errors_have_their_size_and_limits_cut() -> None:
    exact, noisy = readings(imu(**EXACT)), readings(imu(force_limit=1e4))
    assert np.std(noisy.turn_rate - exact.turn_rate, axis=0) == pytest.approx(
        [1.2e-4 * 200**0.5] * 3, rel=0.1
    )
    assert np.std(noisy.specific_force - exact.specific_force, axis=0) == pytest.approx(
        [1.2e-3 * 200**0.5] * 3, rel=0.1
    )
    bias = (noisy.turn_rate - exact.turn_rate).mean(axis=0)
    assert (np.abs(bias) > 1e-4).any()
    assert np.abs(readings(imu(force_limit=10.0)).specific_force).max() == 10.0


def test_each_sensor_has_its_own_ball_and_its_own_errors_and_seeds_repeat() -> None:
    red, again, green = readings(imu()), readings(imu()), readings(imu("imu_green"))
    assert np.array_equal(red.specific_force, again.specific_force)
    assert not np.allclose(red.specific_force, green.specific_force)
    assert not np.array_equal(red.turn_rate, readings(imu(seed=8)).turn_rate)


@pytest.mark.parametrize(
    ("params", "most"),
    [({"rate": 1000.0}, 10), ({}, 2), ({"batch": 64, "batch_time": 1.0}, 64), ({"batch": 1}, 1)],
)
def test_messages_hold_as_many_readings_as_asked_for_and_end_with_the_pictures(
    params: dict[str, float], most: int
) -> None:
    sent = list(imu(**params).process())
    assert {len(message.time) for message in sent[:-1]} == {most}
    assert all(message.header.time == message.time[-1] for message in sent)
    times = np.concatenate([message.time for message in sent])
    assert (np.diff(times) > 0).all()
    assert times[0] == 0
    rate = params.get("rate", 200.0)
    assert times[-1] == round(int(239 / 60 * rate) * 1e9 / rate)
    assert all(a.time[-1] < b.time[0] for a, b in pairwise(sent))


def test_the_size_of_messages_does_not_change_what_is_read() -> None:
    few, many = readings(imu(batch=1, **EXACT)), readings(imu(batch=50, batch_time=1.0, **EXACT))
    assert np.array_equal(few.time, many.time)
    assert np.allclose(few.specific_force, many.specific_force, atol=1e-6)


def test_readings_that_come_late_by_the_clock_are_those_of_a_later_moment() -> None:
    late, prompt = imu(clock_offset=0.1, **EXACT), imu(**EXACT)
    ahead = readings(prompt).specific_force[20:420]
    assert np.allclose(readings(late).specific_force[:400], ahead, atol=1e-6)


def test_truth_is_that_of_the_places_with_unit_quaternions() -> None:
    truth = truths(3)[2]
    assert truth.objects == ("green", "red", "blue")
    assert np.allclose(np.linalg.norm(truth.quaternion, axis=1), 1.0)
    names = [cells.name for cells in truth.as_table(ROOM)]
    assert names[-4:] == ["qw", "qx", "qy", "qz"]
    assert {"object", "x", "y", "z", "trackable"} <= set(names)


def test_turn_rates_are_as_fast_as_asked_for() -> None:
    found = readings(imu(frames=2400, turn_rate=3.0, rate=50, **EXACT))
    assert np.sqrt(np.square(found.turn_rate).sum(axis=1).mean()) == pytest.approx(3.0, rel=0.35)


def test_a_sensor_on_no_target_is_refused_with_a_remedy(tiny_room) -> None:
    loose = replace(tiny_room, sensors={"imu0": replace(tiny_room.sensors["imu0"], mount=None)})
    with pytest.raises(InputError, match="mounted on no target"):
        SimImu(Context("imu", loose, Member("sensors", "imu0"))).setup()
