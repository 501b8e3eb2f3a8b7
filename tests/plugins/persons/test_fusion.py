"""Several cameras' poses as people of the room: how far a person gets, and who is the same person again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import SECOND
from tests.plugins.persons.fused_cameras import RATE, Cameras, camera_poses
from tests.travelled import travelled

from followspot.messages import Header, identical, stamped
from followspot.tracking import PREDICTED, TRACKED
from followspot_persons.pose_fusion.position_filter import GATE, PositionTrack


def walked(cameras, frames, *, number=1, x=2.0, y=0.0, speed=0.0):
    """The last fused poses of a person that camera `a` follows along y, m/s."""
    for frame in range(frames):
        told = cameras.tell(("a", number, x, y + speed * frame / RATE))
    return told


@pytest.mark.parametrize("step", [0.3, 0.65])
def test_a_person_does_not_go_four_metres_in_0_4_s_however_small_the_steps(step):
    """A camera's pose runs away along the line of sight, where it is least sure of the distance."""
    cameras = Cameras()
    walked(cameras, 15)
    places = [cameras.tell(("a", 1, 2.0 + min(4.0, step * frame), 0.0)).xy[0, 0] for frame in range(1, 1 + 6)]
    assert max(places) < 2.0 + 1.6
    assert max(np.diff(places)) < 0.5


def test_what_nobody_can_have_reached_is_another_person():
    cameras = Cameras(maximum_distance=9.0)
    walked(cameras, 15)
    for _ in range(4):
        told = cameras.tell(("a", 1, 2.0, 6.0))
    assert told.person.tolist() == [1]
    assert told.state.tolist() == [PREDICTED]
    assert told.xy[0] == pytest.approx([2.0, 0.0], abs=0.1)
    told = walked(cameras, 12, y=6.0)
    assert told.person.tolist() == [2]
    assert told.state.tolist() == [TRACKED]


def test_a_person_never_is_two():
    """Camera `b` is wrong about the distance of the person, which `a` sees where it is."""
    cameras = Cameras()
    for wrong in np.linspace(2.0, 4.0, 20):
        told = cameras.tell(("a", 1, 2.0, 0.0), ("b", 4, wrong, 0.0))
    assert told.person.tolist() == [1]
    for _ in range(6):
        told = cameras.tell(("a", 1, 2.0, 0.0), ("b", 5, 2.0, 0.6))
    assert told.person.tolist() == [1]
    for _ in range(6):
        told = cameras.tell(("a", 1, 2.0, 0.0), ("b", 4, 2.0, 0.0), ("b", 5, 2.0, 0.6))
    assert told.person.tolist() == [1, 2]


@pytest.mark.parametrize("speed", [0.0, 0.8, 1.6])
def test_walking_people_stay_within_the_gate(speed):
    cameras = Cameras()
    told = walked(cameras, 24, y=-1.2, speed=speed)
    assert told.person.tolist() == [1]
    assert told.xy[0] == pytest.approx([2.0, -1.2 + speed * 23 / RATE], abs=0.08)


def test_both_cameras_of_a_person_count():
    """Camera `b` takes the person for farther away; both are as sure."""
    cameras = Cameras()
    for _ in range(20):
        told = cameras.tell(("a", 1, 2.0, 0.0), ("b", 4, 2.2, 0.0))
    assert told.person.tolist() == [1]
    assert 2.02 < told.xy[0, 0] < 2.18


@pytest.mark.parametrize(("away", "number"), [(1.0, 1), (6.0, 2)])
def test_whom_a_camera_knows_again_has_its_number_if_it_can_be_there_by_now(away, number):
    cameras = Cameras()
    walked(cameras, 15)
    for _ in range(12):
        told = cameras.tell()
    assert told.person.tolist() == []
    assert walked(cameras, 4, y=away).person.tolist() == [number]


def test_the_place_is_the_kalman_estimate_of_two_measurements():
    """Information adds up: (P^-1 + R^-1)^-1 (P^-1 x + R^-1 z)."""
    P, R = np.array([[0.04, 0.01], [0.01, 0.02]]), np.diag([0.01, 0.05])
    x, z = np.array([1.0, 2.0]), np.array([1.2, 1.9])
    after = PositionTrack.initiated(x, P).updated(z, R)
    together = np.linalg.inv(np.linalg.inv(P) + np.linalg.inv(R))
    np.testing.assert_allclose(after.covariance[:2, :2], together)
    np.testing.assert_allclose(after.state[:2], together @ (np.linalg.solve(P, x) + np.linalg.solve(R, z)))


def test_the_gate_is_where_one_of_a_thousand_is_farther():
    rng = np.random.default_rng(3)
    track = PositionTrack.initiated(np.zeros(2), np.diag([0.04, 0.01]))
    noise = rng.standard_normal((200_000, 2)) * np.sqrt([0.05, 0.03])
    inside = track.in_gate(noise, np.tile(np.diag([0.01, 0.02]), (len(noise), 1, 1)))
    assert 1 - inside.mean() == pytest.approx(np.exp(-GATE / 2), rel=0.2)
    assert np.exp(-GATE / 2) == pytest.approx(1e-3, rel=0.02)


def test_a_place_is_vaguer_the_longer_nobody_sees_it():
    track = PositionTrack.initiated(np.zeros(2), 0.01 * np.eye(2))
    once, twice = track.predicted(0.4), track.predicted(0.2).predicted(0.2)
    np.testing.assert_allclose(once.covariance, twice.covariance)
    assert 0.1 < np.sqrt(once.covariance[0, 0]) < np.sqrt(track.predicted(1.0).covariance[0, 0]) < 1.0


def room_poses(*people, sigma=0.02):
    """Poses of the room. people: number, x, y."""
    return replace(
        camera_poses("", people), sigma=np.full((len(people), 6), sigma), height=np.full(len(people), 1.6)
    )


def test_poses_of_the_room_count_by_their_own_sigma():
    """A camera is unsure of the distance; what is found over several cameras is not."""
    for sigma, near in ((0.02, 2.3), (1.0, 2.0)):
        cameras = Cameras()
        for frame in range(6):
            time = Header("fuse", frame, frame * SECOND // RATE)
            told = stamped(camera_poses("a", [(1, 2.0, 0.0)]), time)
            room = stamped(room_poses((5, 2.3, 0.0), sigma=sigma), time)
            found = cameras.stage.process((told,), (room,))
        assert found.person.tolist() == [1]
        assert abs(found.xy[0, 0] - near) < 0.1


def test_poses_of_the_room_alone_keep_their_heights_and_poses_of_cameras_are_none_of_them():
    cameras = Cameras()
    for frame in range(4):
        time = Header("fuse", frame, frame * SECOND // RATE)
        other = stamped(camera_poses("a", [(1, 4.0, 4.0)]), time)
        found = cameras.stage.process((), (stamped(room_poses((5, 1.0, 2.0)), time), other))
    assert found.person.tolist() == [1]
    np.testing.assert_allclose(found.xy, [[1.0, 2.0]])
    np.testing.assert_allclose(found.height, [1.6])


def test_a_successor_carries_on_with_the_people_their_numbers_and_the_deleted_ones():
    def told(cameras, frame):
        left = [("a", 1, 2.0, 0.0), ("b", 1, 2.0, 0.0)] if frame < 8 or frame > 25 else []
        return cameras.tell(*left, ("a", 2, 3.0, 1.5))

    whole, before, after = Cameras(), Cameras(), Cameras()
    expected = [told(whole, frame) for frame in range(40)]
    for frame in range(22):
        told(before, frame)
    after.stage.restore(travelled(before.stage.state()))
    after.frame = before.frame
    found = [told(after, frame) for frame in range(22, 40)]
    assert all(identical(a, b) for a, b in zip(found, expected[22:], strict=True))
    assert found[-1].person.tolist() == [1, 2]
