"""The ball tracker on six cameras of Aravis that show the simulated room, triggered by software."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.plugins.cameras.aravis_pictures import shown

from followspot.cli.main import main
from followspot.room import StageUse, Sync
from followspot.room_file import load, save

ROOT = Path(__file__).parents[3]
SYSTEM = Path("/usr/lib/python3/dist-packages")
PICTURES = Path(__file__).with_name("aravis_pictures.py")
FRAMES, RATE = 60, 4.0
TAKEN = 40
COMMAND = Path(sys.executable).with_name("followspot")
ARAVIS = "import gi; gi.require_version('Aravis', '0.8')"
NAMESPACE = ["unshare", "--net", "--map-root-user"]
"""Addresses of loopback that nobody else uses."""

pytestmark = pytest.mark.thorough


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """One in which Python sees the system's `gi`, and a namespace may be made."""
    if (SYSTEM / "gi").is_dir():
        (tmp_path / "gi").symlink_to(SYSTEM / "gi")
    found = {**os.environ, "PYTHONPATH": f"{tmp_path}:{ROOT}"}
    if subprocess.run([sys.executable, "-c", ARAVIS], env=found, capture_output=True).returncode:
        pytest.skip("Aravis of the distribution (gir1.2-aravis-0.8, python3-gi) is not installed")
    if subprocess.run([*NAMESPACE, "ip", "link", "set", "lo", "up"], capture_output=True).returncode:
        pytest.skip("network namespaces are not allowed here")
    return found


def recorded(folder: Path) -> Path:
    """A room of cameras by Aravis, and what they show, beside it."""
    simulated = ROOT / "graphs/rooms/simulated.yaml"
    assert main(["simulate", "--room", str(simulated), "--out", str(folder), "--frames", str(FRAMES)]) == 0
    room = load(simulated)
    pictures, cameras = [], {}
    for number, (name, camera) in enumerate(room.cameras.items()):
        video = cv2.VideoCapture(str(folder / f"{name}.mkv"))
        pictures.append([cv2.cvtColor(video.read()[1], cv2.COLOR_BGR2RGB) for _ in range(FRAMES)])
        width, height = camera.size
        features = {"Width": width, "Height": height, "PixelFormat": "RGB8"}
        where = {"camera": f"127.0.0.{number + 1}", "backend": "aravis", "features": features}
        cameras[name] = replace(camera, source=StageUse("cameras.genicam", {**where, "read_timeout": 60.0}))
    np.save(folder / "pictures.npy", np.array(pictures))
    save(replace(room, cameras=cameras, truth=None, sync=Sync("software", rate=RATE)), folder / "room.yaml")
    return folder / "room.yaml"


def test_balls_are_where_the_pictures_show_them(tmp_path: Path, environment: dict[str, str]) -> None:
    room = recorded(tmp_path)
    words = ["run", str(ROOT / "graphs/glowballs.yaml"), "--room", str(room), "--frames", str(TAKEN)]
    script = f"""
        ip link set lo up
        for n in 2 3 4 5 6; do ip addr add 127.0.0.$n/8 dev lo; done
        mkfifo ends told
        {sys.executable} {PICTURES} pictures.npy {RATE} < ends > told &
        exec 3> ends
        read line < told
        test "$line" = running || exit 3
        {COMMAND} {" ".join(words)} --out out --quiet
    """
    done = subprocess.run(
        [*NAMESPACE, "sh", "-c", script],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    with (tmp_path / "truth.csv").open() as file:
        true = {
            (int(row["frame"]), row["object"]): [float(row[axis]) for axis in "xyz"]
            for row in csv.DictReader(file)
        }
    with (tmp_path / "out" / "tracks.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["state"] == "tracked"]
    away = []
    for row in rows:
        moment = round(float(row["time"]) * RATE)
        place = np.array([float(row[axis]) for axis in "xyz"])
        away.append(np.linalg.norm(place - true[shown(moment, FRAMES), row["object"]]))
    assert len(rows) > TAKEN
    assert np.median(away) < 0.02
