"""Options that every command takes, and colours."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from followspot.cli.main import main
from followspot.cli.parser import build_parser
from followspot.tables.terminal import line, literal_console

ROOT = Path(__file__).parents[3]


def commands(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The parsers of all commands, also of those in groups."""
    groups = [one for one in parser._actions if isinstance(one, argparse._SubParsersAction)]
    if not groups:
        yield parser
    for group in groups:
        for choice in group.choices.values():
            yield from commands(choice)


def test_every_command_can_be_quiet_and_can_be_verbose() -> None:
    found = list(commands(build_parser()))
    assert len(found) > 30
    for parser in found:
        options = parser._option_string_actions
        assert options["-q"] is options["--quiet"], parser.prog
        assert options["-v"] is options["--verbose"], parser.prog


def test_quiet_leaves_out_notes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    room = str(ROOT / "graphs/rooms/simulated.yaml")
    words = ["simulate", "--room", room, "--out", str(tmp_path), "--frames", "1"]
    assert main([*words, "-q"]) == 0
    assert capsys.readouterr().err == ""
    assert main(words) == 0
    assert "simulate: 6 videos of 1 frames" in capsys.readouterr().err


def test_verbose_says_where_an_error_comes_from(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "nowhere.yaml"]) == 2
    assert "Traceback" not in capsys.readouterr().err
    assert main(["check", "nowhere.yaml", "-v"]) == 2
    said = capsys.readouterr().err
    assert "Traceback" in said
    assert "nowhere.yaml" in said.rpartition("Traceback")[2]


def test_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert re.fullmatch(r"followspot \d+\.\d+\.\d+\S*\n", capsys.readouterr().out)


@pytest.mark.parametrize("asked", [False, True])
def test_no_color_leaves_out_colours(monkeypatch: pytest.MonkeyPatch, asked: bool) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    if asked:
        monkeypatch.setenv("NO_COLOR", "1")
    console = literal_console(force_terminal=True)
    with console.capture() as drawn:
        console.print(line("lost", bad=True))
    assert ("31m" in drawn.get()) == (not asked)


def test_colours_come_from_rich_alone() -> None:
    """Which obeys NO_COLOR; codes that wipe a line are no colours."""
    files = [path for part in ("core", "plugins", "tools/commands") for path in (ROOT / part).rglob("*.py")]
    assert len(files) > 500
    assert [path for path in files if re.search(r"(\\x1b|\\033|\\e)\[[\d;]*m", path.read_text())] == []
