"""One-file plugins: how their stages are named, and what is said of files that cannot be used."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from tests.core.plugins.packages import STAGE

from followspot.cli.main import main
from followspot.messages import Message
from followspot.plugins import registry
from followspot.plugins.registry import PluginError, load_stage
from followspot.stage import Stage


class Notice(Message):
    text: str


@pytest.fixture
def no_files(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_files", {})


def one_file(folder: Path, name: str, text: str) -> str:
    (folder / name).write_text(text)
    return str(folder / name)


@pytest.mark.usefixtures("no_files")
def test_each_stage_of_a_file_is_named_after_the_file_and_the_class(tmp_path: Path) -> None:
    text = STAGE.replace("class Piano", "class GrandPiano")
    registry.use_plugin_files([one_file(tmp_path, "keys.py", text)])
    assert load_stage("keys.grand_piano").__name__ == "GrandPiano"
    assert "keys.grand_piano" in registry.stage_names()


@pytest.mark.usefixtures("no_files")
@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("boom.py", "x = 1\n\ny = x / 0\n", "boom.py:3: ZeroDivisionError: division by zero"),
        ("syntax.py", "x = (\n", "syntax.py:1: SyntaxError"),
        ("leaves.py", "\nraise SystemExit(3)\n", "leaves.py:2: SystemExit: 3"),
        ("empty.py", "x = 1\n", "defines no stage"),
        ("Bad-Name.py", STAGE, "name it like a Python module"),
        ("unsigned.py", STAGE.replace(" -> Source[Note]", ""), "unsigned.py:9: Piano.process says not"),
        ("idle.py", STAGE.replace("def process", "def proceed"), "idle.py:8: Piano"),
    ],
)
def test_a_file_that_is_no_plugin_is_one_line(tmp_path: Path, name: str, text: str, said: str) -> None:
    with pytest.raises(registry.FollowspotError) as caught:
        registry.use_plugin_files([one_file(tmp_path, name, text)])
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("no_files")
def test_a_file_cannot_take_a_name_that_is_taken(tmp_path: Path) -> None:
    balls = one_file(tmp_path, "balls.py", STAGE.replace("class Piano", "class Mean"))
    with pytest.raises(PluginError, match=r"balls\.mean is already offered by followspot; rename the file"):
        registry.use_plugin_files([balls])
    (tmp_path / "other").mkdir()
    first, second = one_file(tmp_path, "keys.py", STAGE), one_file(tmp_path / "other", "keys.py", STAGE)
    registry.use_plugin_files([first, first])
    with pytest.raises(PluginError) as caught:
        registry.use_plugin_files([second])
    assert f"{second}: stage keys.piano is already offered by {first}; rename one of the files" in str(
        caught.value
    )


@pytest.mark.usefixtures("no_files")
def test_a_file_that_was_changed_is_read_again_for_a_new_plan_alone(tmp_path: Path) -> None:
    keys = one_file(tmp_path, "keys.py", STAGE)
    registry.use_plugin_files([keys])
    first = load_stage("keys.piano")
    one_file(tmp_path, "keys.py", STAGE.replace("class Piano", "class Organ"))
    registry.use_plugin_files([keys])
    assert load_stage("keys.piano") is first  # a run that goes on keeps its classes
    registry.use_plugin_files([keys], changed=True)
    assert load_stage("keys.organ").__name__ == "Organ"
    with pytest.raises(PluginError, match=r'no stage "keys\.piano"'):
        load_stage("keys.piano")
    registry.use_plugin_files([keys], changed=True)
    assert load_stage("keys.organ") is load_stage("keys.organ")


@pytest.mark.usefixtures("no_files")
def test_a_change_that_breaks_a_file_is_told_and_leaves_its_module(tmp_path: Path) -> None:
    keys = one_file(tmp_path, "keys.py", STAGE)
    registry.use_plugin_files([keys])
    module = sys.modules["followspot_file_keys"]
    one_file(tmp_path, "keys.py", "x = 1 / 0\n")
    with pytest.raises(registry.FollowspotError, match="ZeroDivisionError"):
        registry.use_plugin_files([keys], changed=True)
    assert sys.modules["followspot_file_keys"] is module


def test_each_class_of_one_name_has_a_name_of_its_own() -> None:
    def made() -> type[Stage]:
        class Twin(Stage):
            """A stage of a function, as each of its calls makes one."""

            def process(self, text: Notice) -> None: ...

        return Twin

    first, second = made(), made()
    names = [registry.offer_stage(stage) for stage in (first, second, first)]
    assert names == ["here.twin", "here.twin_2", "here.twin"]
    assert [load_stage(name) for name in names] == [first, second, first]


@pytest.mark.usefixtures("no_files")
def test_a_file_that_is_missing_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(registry.FollowspotError, match=r"none\.py cannot be read: No such file"):
        registry.use_plugin_files([str(tmp_path / "none.py")])


@pytest.mark.usefixtures("no_files")
def test_a_broken_file_hides_no_stage_from_the_listing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken, keys = one_file(tmp_path, "boom.py", "x = 1 / 0\n"), one_file(tmp_path, "keys.py", STAGE)
    files = ["--plugin", broken, "--plugin", keys]
    assert main(["plugins", *files]) == 1
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["keys.piano", keys, "ok"] in rows
    assert ["balls.mean", "followspot", "ok"] in rows
    (row,) = [row for row in rows if row[:1] == ["boom"]]
    assert row[1:4] == [broken, "broken", f"{broken}:1:"]
    assert main(["plugins", "keys.piano", *files]) == 0
    assert main(["plugins", "boom.piano", *files]) == 1
    assert "ZeroDivisionError" in capsys.readouterr().err
