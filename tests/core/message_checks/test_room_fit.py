"""Messages that keep their contract and speak of what a room has not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from followspot.message_checks.room_fit import fit_check
from followspot.message_checks.sealing import seal
from followspot.messages import Message, column
from followspot.people import Poses
from followspot.room import Room
from followspot.testing.samples import BLACK, sample
from followspot.testing.tiny_room import tiny_room
from followspot.tracking import (
    Blobs,
    Candidates,
    DepthImage,
    Forecast,
    Frame,
    ImageTracks,
    Pairs,
    Positions,
    Tracks,
)

ROOM = tiny_room()
KINDS = (Blobs, Candidates, DepthImage, Forecast, Frame, ImageTracks, Pairs, Poses, Positions, Tracks)


def why(message: Message, room: Room = ROOM) -> str:
    ask = fit_check(type(message), room)
    return "" if ask is None else ask(seal(message))


def made(kind: type[Message], **changes: Any) -> Message:
    values = {**vars(sample(kind, "plausible", ROOM, next(iter(ROOM.cameras)), BLACK)), **changes}
    return kind(**values)


@pytest.mark.parametrize("content", ["empty", "plausible", "unknown"])
@pytest.mark.parametrize("kind", KINDS)
def test_what_stages_of_the_room_send_belongs_to_it(kind: type[Message], content: Any) -> None:
    assert why(sample(kind, content, ROOM, next(iter(ROOM.cameras)), BLACK)) == ""


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (made(Frame, camera="elsewhere"), "no camera 'elsewhere'"),
        (made(Frame, camera=""), "it names no camera"),
        (made(Frame, pixels=np.zeros((0, 0, 3), "u1")), "pixels has shape (0, 0, 3)"),
        (made(Frame, pixels=np.zeros((48, 64, 1), "u1")), "pixels has shape (48, 64, 1)"),
        (made(Frame, pixels=np.zeros((64, 48, 3), "u1")), "gives (48, 64, 3)"),
        (made(DepthImage, depth=np.zeros((64, 48), "f4")), "depth has shape (64, 48)"),
        (made(DepthImage, camera="elsewhere"), "no camera 'elsewhere'"),
        (made(Blobs, camera="a" * 60_000), "no camera 'aaa"),
        (made(Blobs, targets=np.ones((1, 999), bool)), "targets is of 999 targets, the room has"),
        (made(Pairs, cameras=("cam0", "elsewhere")), "no camera 'elsewhere'"),
        (made(Pairs, cameras=()), "view holds 0 to 1, where 0 to -1 can be"),
        (made(Candidates, view=np.array([[0, 2**31 - 1]], "i4")), "view holds 0 to 2147483647"),
        (made(Candidates, view=np.array([[-1, 0]], "i4")), "view holds -1 to 0"),
        (made(Positions, target=np.array([2**31 - 1], "i4")), "target holds 2147483647"),
        (made(Tracks, target=np.array([-1], "i4")), "target holds -1"),
        (made(Tracks, state=np.array([4], "u1")), "state holds 4 to 4, where 0 to 3 can be"),
        (made(Poses, state=np.array([255], "u1")), "state holds 255"),
        (made(Forecast, state=np.full(len(ROOM.targets), 9, "u1")), "state holds 9"),
    ],
)
def test_what_cannot_be_of_the_room_is_named(message: Message, reason: str) -> None:
    assert reason in why(message)


def test_a_stage_of_one_camera_speaks_for_no_other() -> None:
    ours, theirs = list(ROOM.cameras)[:2]
    ask = fit_check(Blobs, ROOM, ours)
    assert ask is not None
    assert ask(made(Blobs, camera=ours)) == ""
    assert ask(made(Blobs, camera=theirs)) == f"it is of camera '{theirs}', not '{ours}'"


def test_poses_that_are_fused_name_no_camera() -> None:
    assert why(made(Poses, camera="")) == ""


def test_a_room_without_cameras_and_targets_has_nothing_to_say_about_them() -> None:
    assert why(made(Frame, camera="elsewhere"), Room()) == ""
    assert why(made(Tracks, target=np.array([99], "i4")), Room()) == ""


def test_types_that_refer_to_nothing_are_not_asked() -> None:
    class Number(Message):
        value: int
        load: Any = column("N", dtype="u1")

    assert fit_check(Number, ROOM) is None
