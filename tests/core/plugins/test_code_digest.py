"""Two hosts tell by digests whether they would run the same code."""

from __future__ import annotations

from pathlib import Path

from followspot.plugins.code_digest import code_digests, other_code
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
    assert list(known) == ["followspot", "followspot_balls", "digested.py"]
    assert other_code(known, stages) == []
    assert other_code({}, stages) == []


def test_a_file_that_was_changed_is_other_code(tmp_path: Path) -> None:
    file = tmp_path / "changed.py"
    file.write_text(STAGE)
    use_plugin_files([str(file)])
    known = code_digests(["changed.same", "balls.kalman"])
    file.write_text(STAGE + "\n")
    assert other_code(known, ["changed.same", "balls.kalman"]) == ["changed.py"]
