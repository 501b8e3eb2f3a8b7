"""What the Rerun viewer is shown; without rerun-sdk the stage says what to install."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from followspot import Context, Message
from followspot.errors import FollowspotError
from followspot.inertial import PosedTracks
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.people import Poses, PoseTruth, Skeletons, bones_of
from followspot.testing import tiny_room
from followspot.tracking import Blobs, Candidates, Frame, Pairs, Positions, Tracks, Truth
from followspot_sinks.rerun.layout import layout_of
from followspot_sinks.rerun.scene import entity_of, parts_of
from followspot_sinks.rerun.viewer import Rerun

ROOM = tiny_room()
XYZ = np.array([[0.0, 0.1, 1.0], [np.nan, 0.0, 0.0]])


def sent(message: Message) -> Message:
    return stamped(seal(message), Header("camera", 0, 5_000_000))


TRACKS = Tracks(np.array([0, 9], "i4"), np.array([1, 3], "u1"), np.zeros((2, 3)), np.zeros((2, 3)), XYZ)

POSED = PosedTracks(
    np.array([0, 1], "i4"),
    np.ones(2, "u1"),
    np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
    np.zeros((2, 3)),
    np.array([[0.1, 0.2, 0.3], [np.nan, 0.0, 0.0]]),
    np.array([[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)], [np.nan] * 4]),
    np.zeros(2),
)


def test_without_the_package_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(FollowspotError, match=r"pip install .followspot\[rerun\]"):
        Rerun(Context("show", ROOM, out=tmp_path)).setup()
    (mistake,) = Rerun.check_files(Rerun.Params(), ROOM, None)
    assert mistake.warning
    assert "followspot[rerun]" in mistake.remedy


def test_the_viewer_opens_with_the_room_beside_its_cameras() -> None:
    """The entities that the layout shows are those that messages of the room get."""
    shown: dict[str, str] = {}

    def view(origin: str, name: str) -> None:
        shown[origin] = name

    def arrange(*parts: object, **_: object) -> None:
        pass

    blueprint = SimpleNamespace(
        Spatial3DView=view, Spatial2DView=view, Grid=arrange, Horizontal=arrange, Blueprint=arrange
    )
    layout_of(blueprint, ROOM)
    frames = {entity_of(Frame(name, np.zeros((4, 4, 3), "u1")), "camera"): name for name in ROOM.cameras}
    assert shown == {"room": ROOM.name} | frames


def test_what_a_camera_saw_stands_below_the_camera() -> None:
    frame = Frame("cam0", np.zeros((4, 4, 3), "u1"))
    assert entity_of(frame, "camera") == "room/cam0"
    assert entity_of(Poses.empty(), "track") == "room/track"
    assert entity_of(TRACKS, "track") == "room/track"


@pytest.mark.parametrize(
    "message",
    [
        Frame("cam0", np.zeros((4, 6, 3), "u1")),
        Frame("cam0", np.zeros((4, 6, 1), "u1")),
        TRACKS,
        POSED,
        *(
            kind.empty()
            for kind in (Frame, Tracks, Blobs, Candidates, Positions, Poses, PoseTruth, Skeletons, Truth)
        ),
    ],
)
def test_it_is_written_into_a_file_of_the_viewer(tmp_path: Path, message: Message) -> None:
    pytest.importorskip("rerun")
    told: list[str] = []
    stage = Rerun(Context("show", ROOM, out=tmp_path, warn=told.append))
    stage.setup()
    stage.process(sent(message))
    stage.close()
    assert (tmp_path / "show.rrd").read_bytes().startswith(b"RRF")
    assert told == []


def test_a_type_that_the_viewer_does_not_know_is_told_once(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    told: list[str] = []
    stage = Rerun(Context("show", ROOM, out=tmp_path, warn=told.append))
    stage.setup()
    for _ in range(3):
        stage.process(sent(Pairs.empty()))
    stage.close()
    assert told == ["Rerun shows nothing like Pairs"]


def test_a_file_that_is_removed_while_it_is_written_is_told(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    stage = Rerun(Context("show", ROOM, out=tmp_path))
    stage.setup()
    stage.process(sent(TRACKS))
    (tmp_path / "show.rrd").unlink()
    with pytest.raises(FollowspotError, match=r"show\.rrd was moved or removed"):
        stage.process(sent(TRACKS))
    with pytest.raises(FollowspotError, match=r"show\.rrd was moved or removed"):
        stage.close()


class Kept:
    """Stands for the module `rerun`: an archetype is what it was made of."""

    def __getattr__(self, name: str) -> object:
        return lambda **columns: (name, columns)


def test_skeletons_have_a_bone_between_known_joints_of_one_person() -> None:
    skeletons = Skeletons(
        labels=("left_elbow", "tail", "left_wrist"),
        person=np.array([4, 4, 4, 5, 6], "i4"),
        label=np.array([2, 1, 0, 0, 2], "i4"),
        xyz=np.arange(15.0).reshape(5, 3),
        covariance=np.zeros((5, 3, 3)),
        views=np.ones(5, "i4"),
    )
    name, found = parts_of(Kept(), skeletons)["bones"]
    assert name == "LineStrips3D"
    assert found["strips"].tolist() == [[[6, 7, 8], [0, 1, 2]]]
    ends, person = bones_of(skeletons)
    assert (ends.tolist(), person.tolist()) == ([[[6, 7, 8], [0, 1, 2]]], [4])


def test_tracks_have_an_ellipsoid_of_three_sigma_and_axes_where_they_are_known() -> None:
    parts = parts_of(Kept(), POSED)
    name, found = parts["uncertainty"]
    assert name == "Ellipsoids3D"
    assert found["centers"].tolist() == [[1, 2, 3]]
    np.testing.assert_allclose(found["half_sizes"], [[0.3, 0.6, 0.9]])
    name, found = parts["axes"]
    assert name == "Arrows3D"
    assert found["origins"].tolist() == [[1, 2, 3]] * 3
    np.testing.assert_allclose(
        found["vectors"], 0.2 * np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]), atol=1e-9
    )
    assert found["colors"].tolist() == [[255, 0, 0], [0, 255, 0], [0, 0, 255]]
    assert set(parts_of(Kept(), TRACKS)) == {"uncertainty"}
    assert not parts_of(Kept(), Frame.empty())
