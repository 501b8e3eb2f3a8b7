"""Rooms survive being written, shipped and edited by tools."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.core.graph.files import ROOM

from followspot.errors import InputError
from followspot.room import Camera, Member, Room, Sensor, StageUse, Target
from followspot.room_document.data import from_data, to_data
from followspot.room_file import load, save, update
from followspot.valid_values.names import HOST_NAME, is_title

finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
near = st.floats(-1e4, 1e4)
names = st.text(alphabet="abcXYZ019_-", min_size=1, max_size=8)
words = st.text(max_size=12).filter(bool)
tags = st.dictionaries(
    st.sampled_from(["zone", "rig", "1", "null"]),
    st.lists(st.sampled_from(["hall", "stage", "7", "true", "off", "-"]), min_size=1, unique=True).map(tuple),
)


@st.composite
def rotations(draw: st.DrawFn) -> np.ndarray:
    axis = np.array(draw(st.tuples(*[st.floats(-1, 1)] * 4)))
    w, x, y, z = axis / np.linalg.norm(axis) if np.linalg.norm(axis) > 0.1 else (1.0, 0.0, 0.0, 0.0)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@st.composite
def cameras(draw: st.DrawFn, name: str) -> Camera:
    fx, fy, cx, cy = draw(st.tuples(*[st.floats(1e-3, 1e6)] * 4))
    model = draw(st.sampled_from(["pinhole", "fisheye"]))
    params = draw(
        st.dictionaries(
            words, st.one_of(words, finite, st.booleans(), st.integers(-(2**63), 2**63 - 1)), max_size=3
        )
    )
    return Camera(
        name,
        draw(st.sampled_from(["color", "infrared"])),
        (draw(st.integers(1, 4000)), draw(st.integers(1, 4000))),
        np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]),
        np.array(draw(st.tuples(*[near] * (5 if model == "pinhole" else 4)))),
        draw(rotations()),
        np.array(draw(st.tuples(*[near] * 3))),
        model,
        draw(st.none() | st.just(StageUse("cameras.video", params, "elsewhere"))),
        draw(st.just("") | st.from_regex(HOST_NAME, fullmatch=True)),
        draw(st.just(0.0) | st.floats(-1.0, 1.0)),
        draw(tags),
    )


@st.composite
def sensors(draw: st.DrawFn, name: str) -> Sensor:
    return Sensor(
        name,
        draw(st.sampled_from(["imu", "color", "1"])),
        draw(st.none() | st.just(StageUse("toy.imu", {"port": 7}, "elsewhere"))),
        draw(st.none() | st.floats(1e-6, 1e6)),
        draw(st.none() | st.just(Member("targets", "green"))),
        draw(st.just("") | st.from_regex(HOST_NAME, fullmatch=True)),
        draw(tags),
    )


@st.composite
def rooms(draw: st.DrawFn) -> Room:
    found = {name: draw(cameras(name)) for name in draw(st.lists(names, max_size=3, unique=True))}
    planes = {"floor": np.array([0.0, 0.0, 1.0, draw(near)])} if draw(st.booleans()) else {}
    bins = np.array(draw(st.lists(st.floats(0.01, 1.0), min_size=16, max_size=16)))
    target = Target(
        "green",
        draw(st.floats(1e-3, 1.0)),
        dict.fromkeys(found, bins / bins.sum()),
        dict.fromkeys(found, (draw(st.floats(0, 10)), draw(st.floats(10, 1e6)))),
        dict.fromkeys(found, (0.0, 255.0)),
        draw(tags),
    )
    others = draw(st.lists(names.filter(lambda name: name not in found), max_size=2, unique=True))
    return Room(
        draw(words.filter(is_title)),
        found,
        planes,
        {"green": target},
        draw(st.none() | st.just(StageUse("sim.truth"))),
        {name: draw(sensors(name)) for name in others},
    )


@settings(max_examples=60, deadline=None)
@given(rooms())
def test_a_shipped_room_is_the_same_bit_for_bit(room: Room) -> None:
    data = to_data(room)
    assert to_data(from_data(json.loads(json.dumps(data)))) == data


@settings(max_examples=60, deadline=None)
@given(room=rooms())
def test_a_saved_room_is_read_back_bit_for_bit(room: Room, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.getbasetemp()
    save(room, folder / "round.yaml")
    expected, found = to_data(room), to_data(load(folder / "round.yaml"))
    parts = [*expected["cameras"].values(), *expected["sensors"].values()]
    for use in [*(part.get("source") for part in parts), expected.get("truth")]:
        if use is not None:
            use["folder"] = str(folder)
    assert found == expected


@pytest.fixture
def room_file(tmp_path: Path) -> Path:
    path = tmp_path / "room.yaml"
    path.write_text(ROOM, encoding="utf-8")
    return path


def learnt(name: str) -> Target:
    return Target(name, 0.05, {"cam0": np.full(16, 1 / 16)}, {"cam0": (3.0, 9.5)}, {})


def test_a_camera_says_where_its_paths_begin(room_file: Path) -> None:
    source = load(room_file).cameras["cam0"].source
    assert source == StageUse("toy.camera", {"frames": 20}, str(room_file.parent))


def test_learning_targets_leaves_every_other_line_and_comment(room_file: Path) -> None:
    commented = ROOM.replace("targets:", "# balls\ntargets:   # learnt").replace(
        "truth:", "\n# written by hand\ntruth:"
    )
    room_file.write_text(commented, encoding="utf-8")
    update(room_file, targets={"red": learnt("red")})
    text = room_file.read_text(encoding="utf-8")
    before, after = commented.split("targets:   # learnt")[0], commented[commented.index("\n# written") :]
    assert text.startswith(before)
    assert text.endswith(after)
    assert list(load(room_file).targets) == ["red"]
    assert load(room_file).targets["red"].area == {"cam0": (3.0, 9.5)}


def test_a_room_that_a_link_names_is_written_where_it_is(room_file: Path) -> None:
    link = room_file.with_name("link.yaml")
    link.symlink_to(room_file)
    update(link, targets={"blue": Target("blue", 0.05)})
    assert link.is_symlink()
    assert list(load(room_file).targets) == ["blue"]


def test_a_room_with_line_ends_of_windows_keeps_them(room_file: Path) -> None:
    room_file.write_bytes(room_file.read_bytes().replace(b"\n", b"\r\n"))
    update(room_file, targets={"blue": Target("blue", 0.05)})
    written = room_file.read_bytes()
    assert written.count(b"\n") == written.count(b"\r\n") > 9
    assert list(load(room_file).targets) == ["blue"]


def test_learning_targets_works_where_the_room_has_none(room_file: Path) -> None:
    room_file.write_text(ROOM[: ROOM.index("targets:")].rstrip("\n"), encoding="utf-8")
    update(room_file, targets={"red": learnt("red")})
    assert list(load(room_file).targets) == ["red"]


def test_learning_targets_works_where_cameras_borrow_from_targets(room_file: Path) -> None:
    text = "targets: {green: {radius: &r 0.1}}\nplanes: {floor: [0, 0, 1, *r]}\n"
    room_file.write_text(text, encoding="utf-8")
    update(room_file, targets={"red": Target("red", 0.05)})
    room = load(room_file)
    assert list(room.targets) == ["red"]
    np.testing.assert_array_equal(room.planes["floor"], [0, 0, 1, 0.1])


def test_wrong_targets_leave_the_file_untouched(room_file: Path) -> None:
    stranger = Target("red", 0.05, {}, {"cam9": (1.0, 2.0)}, {})
    with pytest.raises(InputError, match='no camera "cam9"'):
        update(room_file, targets={"red": stranger})
    assert room_file.read_text(encoding="utf-8") == ROOM
    assert [path.name for path in room_file.parent.iterdir()] == ["room.yaml"]


def test_sections_change_together_and_comments_outside_them_stay(room_file: Path) -> None:
    text = "# the studio\n" + ROOM[: ROOM.index("targets:")] + "# balls\n" + ROOM[ROOM.index("targets:") :]
    room_file.write_text(text, encoding="utf-8")
    before = load(room_file)
    moved = {
        name: replace(camera, translation=camera.translation + 1) for name, camera in before.cameras.items()
    }
    update(room_file, cameras=moved, planes={"wall": np.array([1.0, 0.0, 0.0, 2.0])})
    after = load(room_file)
    assert list(after.planes) == ["wall"]
    assert after.cameras["cam0"].source == before.cameras["cam0"].source
    np.testing.assert_array_equal(after.cameras["cam0"].translation, moved["cam0"].translation)
    assert text[text.index("# balls") :] in room_file.read_text(encoding="utf-8")
    assert room_file.read_text(encoding="utf-8").startswith("# the studio\n")


def test_nearly_unit_normals_and_histograms_are_normalised(room_file: Path) -> None:
    rounded = ROOM.replace("[0, 0, 1, 0]", "[0, 0.6, 0.8002, 1]").replace(
        "[1, 0, 0, 0, 0, 0, 0", "[3, 1, 0, 0, 0, 0, 0"
    )
    room_file.write_text(rounded, encoding="utf-8")
    room = load(room_file)
    assert np.linalg.norm(room.planes["floor"][:3]) == pytest.approx(1.0, abs=1e-15)
    assert room.targets["green"].hue_histogram["cam0"][:2].tolist() == [0.75, 0.25]


def test_all_mistakes_of_a_room_are_reported_at_once(room_file: Path) -> None:
    broken = ROOM.replace("kind: color", "kind: a b").replace("[0, 0, 3]", "[0, 0]").replace("0.0762", "-1")
    room_file.write_text(broken, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load(room_file)
    assert [m.place.line for m in caught.value.mistakes if m.place] == [4, 9, 22]


def test_a_file_that_is_no_room_is_quoted_in_part(tmp_path: Path) -> None:
    path = tmp_path / "passwords"
    path.write_text("".join(f"user{i}:x:{i}:/home/user{i}\n" for i in range(50)))
    with pytest.raises(InputError, match=r'a mapping of keys to values, not "user0.*\.\.\."') as raised:
        load(path)
    assert "user9" not in str(raised.value)


def test_a_room_of_too_many_cameras_is_refused(room_file: Path) -> None:
    names = ", ".join(f"c{n}: *c" for n in range(1001))
    room_file.write_text(f"targets: {{a: &c {{radius: 1}}}}\ncameras: {{{names}}}\n", encoding="utf-8")
    with pytest.raises(InputError, match="1001 cameras, at most 1000"):
        load(room_file)


def test_shipped_data_that_is_no_room_is_refused() -> None:
    with pytest.raises(InputError, match="a room is a mapping"):
        from_data([1, 2])
    with pytest.raises(InputError, match='no key "cameras_"'):
        from_data({"cameras_": {}})
