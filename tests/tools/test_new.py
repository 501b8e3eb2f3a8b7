"""A new plugin is a package that works before a line of it is written."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from typing import get_type_hints

import pytest

from followspot import Stage
from followspot.errors import InputError
from followspot.testing import check_stage
from followspot_new.package import new_plugin, new_stage
from followspot_new.stub import message_types


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    folder = new_plugin("studio", tmp_path)
    with pytest.raises(InputError, match="exists already"):
        new_plugin("studio", tmp_path)
    with pytest.raises(InputError, match="exists already"):
        new_stage("low", folder)


def test_a_stage_joins_a_table_with_comments(tmp_path: Path) -> None:
    folder = new_plugin("studio", tmp_path)
    project = folder / "pyproject.toml"
    project.write_text(project.read_text().replace('v1"]', 'v1"]  # ours', 1))
    assert new_stage("shout", folder)[1] == "studio.shout"
    offered = tomllib.loads(project.read_text())["project"]["entry-points"]["followspot.plugins.v1"]
    assert offered == {
        "studio.low": "followspot_studio.low:Low",
        "studio.shout": "followspot_studio.shout:Shout",
    }


@pytest.mark.parametrize("name", ["class", "Shout", "two words", "../shout"])
def test_a_stage_that_is_no_module_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="cannot be the name"):
        new_stage(name, new_plugin("studio", tmp_path))


@pytest.mark.parametrize("name", ["Studio", "../escape", "my-plugin", "", "a b", "1st", "import"])
def test_a_name_that_is_no_module_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="cannot be the name"):
        new_plugin(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["balls", "dashboard", "room"])
def test_a_name_that_is_taken_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="comes with followspot"):
        new_plugin(name, tmp_path)


def test_the_name_of_the_classes_of_scripts_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match='"here" names the classes of a script'):
        new_plugin("here", tmp_path)


@pytest.mark.parametrize("name", ["stage", "stage_params", "tracks", "points2_d", "field"])
def test_a_stage_that_would_hide_a_class_of_followspot_is_refused(tmp_path: Path, name: str) -> None:
    package = new_plugin("studio", tmp_path)
    with pytest.raises(InputError, match="would hide one of followspot"):
        new_stage(name, package)


def test_a_stage_outside_of_a_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no"):
        new_stage("shout", tmp_path)
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "other"\n')
    with pytest.raises(InputError, match="is not one that"):
        new_stage("shout", tmp_path)


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new package, which this process and others can import."""
    folder = new_plugin("studio", tmp_path)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    for name in [name for name in sys.modules if name.partition(".")[0] == "followspot_studio"]:
        monkeypatch.delitem(sys.modules, name)
    return folder


def made(package: Path, name: str, takes: list[str], gives: str | None) -> type[Stage]:
    """The class of a new stage."""
    new_stage(name, package, takes, gives)
    kind: type[Stage] = getattr(import_module(f"followspot_studio.{name}"), name.capitalize())
    return kind


@pytest.mark.parametrize(
    ("takes", "gives"),
    [
        (["Blobs"], "Blobs"),
        (["Boxes", "Points2D"], "Skeletons"),
        (["Frame"], "Blobs"),
        (["Tracks"], "Boxes"),
        (["Tracks"], None),
        ([], "Positions"),
        ([], "Blobs"),
    ],
    ids=str,
)
def test_a_stub_has_the_types_that_were_asked_for_and_keeps_every_promise(
    package: Path, takes: list[str], gives: str | None, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")  # pytest keeps what a stub logs, and that is no memory of the stage
    stage = made(package, "some", takes, gives)
    hints = get_type_hints(stage.process)
    result = hints.pop("return")
    assert [kind.__name__ for kind in hints.values()] == takes
    assert (gives or "None") in str(result)
    check_stage(stage)
    test = (package / "tests/test_some.py").read_text()
    assert "from followspot_studio.some import Some" in test
    compile(test, "test_some.py", "exec")


def test_a_stub_of_every_type_is_tidy(package: Path) -> None:
    for kind in message_types():
        for way, takes, gives in (("pass", [kind], kind), ("begin", [], kind), ("use", [kind], None)):
            stage = made(package, f"{way}{kind.lower()}", takes, gives)
            assert stage.__doc__
            assert stage.__doc__.endswith(".")
    style = [
        sys.executable,
        "-m",
        "ruff",
        "check",
        "--isolated",
        "--select",
        "E,F,I,W",
        str(package / "followspot_studio"),
    ]
    done = subprocess.run(style, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("takes", "gives", "said"),
    [
        (["Blob"], None, 'did you mean "Blobs"'),
        ([], "Nothing", 'no message type "Nothing"'),
        (["Blobs", "Blobs"], None, "Joined"),
    ],
)
def test_types_that_are_none_are_refused(
    tmp_path: Path, takes: list[str], gives: str | None, said: str
) -> None:
    folder = new_plugin("studio", tmp_path)
    with pytest.raises(InputError, match=said):
        new_stage("some", folder, takes, gives)
    assert not (folder / "followspot_studio/some.py").exists()
    assert "some" not in (folder / "pyproject.toml").read_text()
