"""Each optional package that is missing is not installed, never broken, and its extra is named."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import metadata
from importlib.util import find_spec

import pytest

MODULES = {
    "certs": ("cryptography",),
    "dashboard": ("starlette", "uvicorn", "websockets"),
    "filterpy": ("filterpy",),
    "genicam": ("viva_genicam", "gi"),
    "imu": ("vqf",),
    "lsl": ("pylsl",),
    "osc": ("pythonosc",),
    "parquet": ("pyarrow",),
    "plots": ("matplotlib",),
    "posenet": ("onnxruntime",),
    "recording": ("mcap", "lz4", "zstandard"),
    "rerun": ("rerun",),
    "ros": ("rosbags",),
    "rtsp": ("av",),
}
"""Modules of the extras; gi is the other program that speaks to cameras."""
OF_STAGES = {"filterpy", "genicam", "osc", "recording", "ros", "rtsp"}
FOR_DEVELOPERS = {"dev", "docs", "mutants", "peers", "web"}
WITHOUT = """
import sys
from importlib.machinery import PathFinder
missing, known = sys.argv[1].split(","), PathFinder.find_spec.__func__

def find(cls, name, path=None, target=None):
    return None if name.partition(".")[0] in missing else known(cls, name, path, target)

PathFinder.find_spec = classmethod(find)
from followspot.cli.main import main
from followspot_doctor.checks import libraries, plugins
from followspot_doctor.report import as_text
main(["plugins"])
print("===")
print(as_text([*libraries.extras(), *plugins.stages(), *plugins.hooks()]))
"""


def told(*extras: str) -> tuple[str, str]:
    """What `plugins` and `doctor` say where the packages of these extras are missing."""
    missing = ",".join(module for extra in extras for module in MODULES[extra])
    command = [sys.executable, "-c", WITHOUT, missing]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env={"COLUMNS": "300"})
    listed, _, examined = done.stdout.partition("===")
    return listed, examined


def check(extras: set[str], listed: str, examined: str) -> None:
    for extra in extras:
        remedy = f"pip install 'followspot[{extra}]'"
        assert remedy in examined
        lines = [line for text in (listed, examined) for line in text.splitlines() if remedy in line]
        assert all("not installed" in line for line in lines)
        assert (remedy in listed) is (extra in OF_STAGES)
    assert "broken" not in listed + examined
    assert "PROBLEM" not in examined
    assert "all importable" in examined


def test_every_extra_of_users_is_known_here() -> None:
    offered = set(metadata("followspot").get_all("Provides-Extra") or ())
    assert MODULES.keys() == offered - FOR_DEVELOPERS


def test_without_any_optional_package_every_extra_is_named() -> None:
    check(set(MODULES), *told(*MODULES))


@pytest.mark.thorough
@pytest.mark.parametrize("extra", MODULES)
def test_without_one_of_them_that_one_is_named(extra: str) -> None:
    listed, examined = told(extra)
    check({extra}, listed, examined)
    present = {name for name, modules in MODULES.items() if any(map(find_spec, modules))} - {extra}
    assert not [name for name in present if f"followspot[{name}]" in listed + examined]
