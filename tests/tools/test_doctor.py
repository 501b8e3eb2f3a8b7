"""Whatever is wrong is named, with a remedy; each problem here is a real one."""

from __future__ import annotations

import json
import os
import resource
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

ROOT = Path(__file__).parent.parent.parent
ROOM = ROOT / "graphs" / "rooms" / "simulated.yaml"


def doctor(*words: object, path: Path | None = None, files: int = 1024) -> tuple[int, list[dict[str, Any]]]:
    """Exit code and findings. path: a folder with more packages; files: most that may be open."""
    environment = {**os.environ, "PYTHONPATH": str(path)} if path else None
    done = subprocess.run(
        [sys.executable, "-m", "followspot.cli.main", "doctor", "--json", *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (files, files)),
    )
    assert done.stdout, done.stderr
    return done.returncode, json.loads(done.stdout)["findings"]


def problems(*words: object, **options: Any) -> dict[str, str]:
    """Subject -> text of every problem; each has a remedy."""
    code, findings = doctor(*words, **options)
    bad = [f for f in findings if f["state"] == "problem"]
    assert code == int(bool(bad))
    assert all(f["remedy"] for f in bad)
    return {f["subject"]: f["text"] for f in bad}


def room_with(folder: Path, source: dict[str, Any], **camera: Any) -> Path:
    """A room of one camera, cam0 of the simulated room with another source."""
    cam0 = yaml.safe_load(ROOM.read_text())["cameras"]["cam0"]
    file = folder / "room.yaml"
    file.write_text(yaml.safe_dump({"cameras": {"cam0": {**cam0, "source": source, **camera}}}))
    return file


def picture(folder: Path, width: int = 320, height: int = 240) -> Path:
    """A folder with one picture."""
    pictures = folder / "pictures"
    pictures.mkdir()
    assert cv2.imwrite(str(pictures / "0000.png"), np.zeros((height, width, 3), np.uint8))
    return pictures


def test_a_sound_computer_room_and_graph_have_no_problem() -> None:
    assert problems("--room", ROOM, "--graph", ROOT / "graphs" / "glowballs.yaml") == {}


def test_a_plugin_that_cannot_be_imported(tmp_path: Path) -> None:
    install(
        tmp_path, "loud", "[followspot.plugins.v1]\nloud.horn = loud:Horn\n", "import nothing_of_this_name\n"
    )
    assert "nothing_of_this_name" in problems(path=tmp_path)["stage loud.horn"]


def test_a_stage_that_two_packages_offer(tmp_path: Path) -> None:
    install(tmp_path, "loud", "[followspot.plugins.v1]\nballs.kalman = loud:Horn\n", "")
    assert "offered by both" in problems(path=tmp_path)["stage balls.kalman"]


def test_a_package_whose_commands_cannot_be_loaded(tmp_path: Path) -> None:
    install(tmp_path, "loud", "[followspot.hooks.v1]\nloud = loud\n", "raise RuntimeError('out of tune')\n")
    assert "out of tune" in problems(path=tmp_path)["commands of loud"]


def test_too_few_open_files() -> None:
    assert problems(files=200)["open files"] == "200 at a time"


def test_an_output_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert "cannot be written" in problems("--out", tmp_path / "file" / "runs")["output folder"]


def test_a_video_that_is_not_there(tmp_path: Path) -> None:
    room = room_with(tmp_path, {"uses": "cameras.video", "with": {"path": "gone.mkv"}})
    assert "gone.mkv does not exist" in problems("--room", room)["cam0"]


def test_a_video_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "cam0.mkv").write_bytes(b"no video at all" * 100)
    room = room_with(tmp_path, {"uses": "cameras.video", "with": {"path": "cam0.mkv"}})
    assert "cam0.mkv" in problems("--room", room)["cam0"]


def test_a_camera_of_another_size_than_it_was_calibrated_at(tmp_path: Path) -> None:
    pictures = picture(tmp_path, 640, 480)
    room = room_with(tmp_path, {"uses": "cameras.images", "with": {"path": str(pictures), "fps": 30}})
    assert "640x480 px, but camera cam0 is calibrated for 320x240" in problems("--room", room)["cam0"]


def test_a_camera_that_is_not_plugged_in(tmp_path: Path) -> None:
    room = room_with(tmp_path, {"uses": "cameras.device", "with": {"device": "/dev/video77"}})
    assert "/dev/video77" in problems("--room", room)["cam0"]


def test_a_stream_that_nobody_sends(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        url = f"rtsp://127.0.0.1:{taken.getsockname()[1]}/cam"
        room = room_with(tmp_path, {"uses": "cameras.stream", "with": {"url": url}})
        assert "127.0.0.1" in problems("--room", room)["cam0"]


def test_a_camera_without_a_source_and_one_with_an_unknown_one(tmp_path: Path) -> None:
    room = room_with(tmp_path, {"uses": "cameras.vidoe"})
    assert 'no stage "cameras.vidoe"' in problems("--room", room)["cam0"]


def test_a_mistake_in_the_room_file(tmp_path: Path) -> None:
    room = room_with(tmp_path, {"uses": "sim.camera"}, kind="colour")
    assert any(subject.startswith(f"room {room}:") for subject in problems("--room", room))


def test_a_mistake_in_the_graph(tmp_path: Path) -> None:
    graph = tmp_path / "graph.yaml"
    graph.write_text("stages: {track: {uses: balls.kalmann, in: {positions: fuse}}}\n")
    found = problems("--graph", graph)
    assert any(subject.startswith(f"graph {graph}:1:") for subject in found)


def test_the_port_of_a_router_that_is_taken_is_a_warning() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 7447))
        taken.listen()
        _, findings = doctor()
    assert {f["subject"]: f["state"] for f in findings}["port 7447"] == "warning"


def test_the_text_counts_what_is_wrong(tmp_path: Path) -> None:
    room = room_with(tmp_path, {"uses": "cameras.video", "with": {"path": "gone.mkv"}})
    words = ("-m", "followspot.cli.main", "doctor", "--room", str(room))
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "PROBLEM" in done.stdout
    assert "1 problem" in done.stdout.splitlines()[-1]


def install(site: Path, name: str, entries: str, module: str) -> None:
    """A distribution with one module."""
    info = site / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(entries)
    (site / f"{name}.py").write_text(module)


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
