"""People in a lit room with glowing balls above them, for graphs that track both."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from followspot import Camera, Context, Room, room_file
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.room import Target
from followspot_sim.actor.show import ShowCamera, ShowTruth

ROOMS = Path(__file__).parents[3] / "graphs" / "rooms"
CAMERA = Camera(
    name="cam",
    kind="color",
    size=(96, 72),
    matrix=np.array([[70.0, 0, 47.5], [0, 70, 35.5], [0, 0, 1]]),
    distortion=np.zeros(5),
    rotation=np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    translation=np.array([0.0, 1.5, 2.5]),
)
TARGETS = {name: Target(name, 0.0762) for name in ("green", "red", "blue")}
ROOM = Room("show", {"cam": CAMERA}, targets=TARGETS)


def test_balls_glow_where_the_truth_says_in_the_colours_of_their_names() -> None:
    camera = ShowCamera(Context.serving(CAMERA, ROOM, name="camera/cam"), frames=2, people=1, noise_sigma=0)
    camera.setup()
    assert camera.length() == 2
    first, second = (seal(message) for message in camera.process())
    assert (first.header.seq, second.header.seq) == (0, 1)
    truth = ShowTruth(Context("truth", ROOM), frames=2, people=1, noise_sigma=0)
    balls = seal(next(iter(truth.process())))
    assert balls.objects == ("green", "red", "blue")
    for (x, y), channel in zip(np.rint(project(CAMERA, balls.xyz)).astype(int), (1, 2, 0), strict=True):
        pixel = first.pixels[y, x].astype(int)
        assert pixel[channel] > 200
        assert pixel[channel] == pixel.max()


def test_a_ball_that_one_camera_sees_cannot_be_placed() -> None:
    truth = ShowTruth(Context("truth", ROOM), frames=1)
    assert not seal(next(iter(truth.process()))).trackable.any()


def test_cameras_and_truth_of_the_ready_room_play_the_same() -> None:
    room = room_file.load(ROOMS / "simulated_show.yaml")
    assert room.truth is not None
    truth = ShowTruth(Context("truth", room), **room.truth.params)
    found = seal(next(iter(truth.process())))
    assert found.trackable.all()
    for camera in room.cameras.values():
        assert camera.source is not None
        assert (camera.source.uses, camera.source.params) == ("sim.show_camera", room.truth.params)
