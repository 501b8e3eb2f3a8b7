"""Two hosts tell by digests whether they would run the same code."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.plugins.code_digest import code_digests, library_versions, other_code
from followspot.plugins.registry import use_plugin_files

STAGE = '''
from followspot import Message, Stage


class Same(Stage):
    """The same message."""

    def process(self, message: Message) -> None: ...
'''


def test_packages_and_files_are_told_by_their_names(tmp_path: Path) -> None:
    file = tmp_path / "digested.py"
    file.write_text(STAGE)
    use_plugin_files([str(file)])
    stages = ["digested.same", "balls.kalman", "balls.mean", "here.gone"]
    known = code_digests(stages)
    assert set(known) == {"followspot", "followspot_balls", "followspot_target_filter", "digested.py"}
    assert other_code(known, stages) == []
    assert other_code({}, stages) == []


def test_a_file_that_was_changed_is_other_code(tmp_path: Path) -> None:
    file = tmp_path / "changed.py"
    file.write_text(STAGE)
    use_plugin_files([str(file)])
    known = code_digests(["changed.same", "balls.kalman"])
    file.write_text(STAGE + "\n")
    assert other_code(known, ["changed.same", "balls.kalman"]) == ["changed.py"]


@pytest.mark.parametrize("name", ["Python", "numpy", "OpenCV"])
def test_another_version_of_a_library_is_other_code(name: str) -> None:
    known = code_digests(["balls.kalman"]) | library_versions()
    assert other_code(known, ["balls.kalman"]) == []
    assert other_code(known | {name: "1.0"}, ["balls.kalman"]) == [name]


BASE = """
from followspot import Message, Stage


class Beat(Message):
    value: int


class Base(Stage):
    pass
"""
DERIVED = """
from {base} import Base, Beat


class Derived({bases}):
    '''Nothing of its own.'''

    def process(self, beat: {message}) -> None: ...
"""


@pytest.mark.parametrize(("bases", "message"), [("Base", "Message"), ("Stage", "Beat")])
def test_packages_that_only_have_base_classes_or_messages_of_stages_are_code_of_theirs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bases: str, message: str
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    name = f"base_of_{bases}".lower()
    package = tmp_path / name
    package.mkdir()
    (package / "__init__.py").write_text(BASE)
    file = tmp_path / f"derived_{bases}.py".lower()
    written = DERIVED.format(base=name, bases=bases, message=message)
    file.write_text(f"from followspot import Message, Stage\n{written}")
    use_plugin_files([str(file)])
    stage = f"{file.stem}.derived"
    known = code_digests([stage])
    (package / "__init__.py").write_text(BASE + "\n")
    assert other_code(known, [stage]) == [name]
