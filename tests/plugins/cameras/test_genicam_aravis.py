"""The backend Aravis, and each backend with the camera of the other; they skip where Aravis is missing."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.plugins.cameras.aravis_trial import SYSTEM
from tests.plugins.cameras.genicam_port import own_port

ROOT = Path(__file__).parents[3]
TRIAL = Path(__file__).parent / "aravis_trial.py"
ARAVIS = "import gi; gi.require_version('Aravis', '0.8'); from gi.repository import Aravis"


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """One in which Python sees the system's `gi`, and nothing else of the system's packages."""
    folder = tmp_path_factory.mktemp("gi")
    if (SYSTEM / "gi").is_dir():
        (folder / "gi").symlink_to(SYSTEM / "gi")
    found = {**os.environ, "PYTHONPATH": f"{folder}:{ROOT}"}
    if subprocess.run([sys.executable, "-c", ARAVIS], env=found, capture_output=True).returncode:
        pytest.skip("Aravis of the distribution (gir1.2-aravis-0.8, python3-gi) is not installed")
    return found


def trial(environment: dict[str, str], camera: str, backend: str, count: int) -> dict[str, Any]:
    command = [sys.executable, str(TRIAL), camera, backend, str(count)]
    with own_port():
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_times_are_the_cameras_and_its_numbers_go_on_after_65535(environment: dict[str, str]) -> None:
    found = trial(environment, "aravis", "aravis", 200)
    stamps, identifiers = np.array(found["stamps"]).T
    assert np.abs(np.array(found["captured"]) - stamps).max() < 100_000
    assert {65_535, 1} <= set(identifiers.tolist())
    lost = found["lost"]["gap"] + found["lost"]["packet_loss"] + found["lost"]["device_overrun"]
    assert found["numbers"][-1] == 199 + lost
    assert np.diff(found["numbers"]).min() == 1
    assert found["shape"] == [48, 64, 3]
    assert found["seen"] == ["Aravis Fake GV01 at 127.0.0.1"]


@pytest.mark.thorough
def test_viva_genicam_takes_the_pictures_of_aravis_camera(environment: dict[str, str]) -> None:
    found = trial(environment, "aravis", "viva-genicam", 200)
    stamps, identifiers = np.array(found["stamps"]).T
    assert np.abs(np.array(found["captured"]) - stamps).max() < 100_000
    assert {65_535, 1} <= set(identifiers.tolist())


@pytest.mark.thorough
def test_aravis_takes_the_pictures_of_viva_genicams_camera(environment: dict[str, str]) -> None:
    found = trial(environment, "viva-genicam", "aravis", 12)
    assert found["numbers"] == [0, 1, 2, 3, 5, 6, 7, 9, 10, 11, 12, 13]
    assert found["lost"] == {"packet_loss": 2, "gap": 0, "device_overrun": 0}
    apart = np.diff(found["captured"]) - np.diff(np.array(found["stamps"])[:, 0])
    assert np.abs(apart[2:]).max() < 5_000_000
