"""A new plugin is a package that works before a line of it is written."""

from __future__ import annotations

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


@pytest.mark.parametrize("name", ["Studio", "../escape", "my-plugin", "", "a b", "1st"])
def test_a_name_that_is_no_module_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="cannot be the name"):
        new_plugin(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_is_taken_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="comes with followspot"):
        new_plugin("balls", tmp_path)


def test_a_stage_outside_of_a_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no"):
        new_stage("shout", tmp_path)
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "other"\n')
    with pytest.raises(InputError, match="is not one that"):
        new_stage("shout", tmp_path)
