"""A new plugin is a package that works before a line of it is written."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from followspot.errors import InputError
from followspot_new.package import new_plugin, new_stage


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    folder = new_plugin("studio", tmp_path)
    with pytest.raises(InputError, match="exists already"):
        new_plugin("studio", tmp_path)
    with pytest.raises(InputError, match="exists already"):
        new_stage("low", folder)


def test_a_stage_joins_a_table_that_somebody_has_commented(tmp_path: Path) -> None:
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


def test_a_stage_outside_of_a_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no"):
        new_stage("shout", tmp_path)
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "other"\n')
    with pytest.raises(InputError, match="is not one that"):
        new_stage("shout", tmp_path)
