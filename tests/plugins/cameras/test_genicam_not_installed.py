"""Without any program that speaks to cameras, `cameras.genicam` is not installed, and the remedy is named."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import pytest

from followspot import InputError
from followspot_cameras.genicam.camera import CameraInfo

WITHOUT = """
import sys
sys.modules["viva_genicam"] = sys.modules["gi"] = None
from followspot.plugins.catalogue import catalogue
from followspot.plugins.registry import examined
found = examined(catalogue()["cameras.genicam"])
print(found.state, "-", found.problem)
"""


def test_without_a_backend_the_stage_is_not_installed() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "not installed - pip install 'followspot[genicam]'"


def test_a_backend_that_is_missing_beside_the_other_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("viva_genicam")
    from followspot_cameras.genicam import backends

    monkeypatch.setattr(backends, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"the backend aravis is not installed(.|\n)*gir1.2-aravis"):
        backends.connected("", "aravis", "", 0)


def test_the_camera_that_is_meant_must_be_named_if_there_are_two(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("viva_genicam")
    from followspot_cameras.genicam import backends

    seen = [CameraInfo("two", str(n), "GigE Vision", f"10.0.0.{n}", "Acme", "A1", f"S{n}") for n in (1, 2)]

    class Two:
        discover = staticmethod(lambda interface, timeout: seen)
        described = staticmethod(lambda info: info)
        connect = staticmethod(lambda info, interface, packet_size: info)

    monkeypatch.setattr(backends, "backends", lambda name: [Two])
    with pytest.raises(InputError, match=r"2 cameras are in sight: Acme A1 S1 at 10\.0\.0\.1, Acme A1 S2"):
        backends.connected("", "any", "", 0)
    seen = [replace(info, name="left") for info in seen]
    with pytest.raises(InputError, match=r"2 cameras are called left: Acme A1 S1 at 10\.0\.0\.1, Acme A1 S2"):
        backends.connected("left", "any", "", 0)
    assert backends.connected("S2", "any", "", 0) == seen[1]
    assert backends.connected("10.0.0.1", "any", "", 0) == seen[0]
