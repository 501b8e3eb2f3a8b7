"""Options may stand before, between and after the words of a command."""

from __future__ import annotations

import argparse
from dataclasses import replace

import pytest

from followspot.cli import main as command_line
from followspot.cli import swap


@pytest.mark.parametrize(
    "words",
    [
        ["--fresh", "glowballs", "fuse=balls.mean", "color.similarity=0.7"],
        ["glowballs", "--fresh", "fuse=balls.mean", "color.similarity=0.7"],
        ["glowballs", "fuse=balls.mean", "--fresh", "color.similarity=0.7", "--json"],
        ["glowballs", "fuse=balls.mean", "color.similarity=0.7", "--fresh"],
    ],
)
def test_options_of_swap_stand_anywhere(words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[argparse.Namespace] = []

    def note(args: argparse.Namespace) -> int:
        """Note what is asked."""
        asked.append(args)
        return 0

    monkeypatch.setattr(
        command_line, "CORE", (replace(next(one for one in swap.COMMANDS if one.name == "swap"), run=note),)
    )
    assert command_line.main(["swap", *words]) == 0
    assert asked[0].words == ["glowballs", "fuse=balls.mean", "color.similarity=0.7"]
    assert asked[0].fresh


def test_a_wrong_option_among_the_words_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command_line.main(["swap", "glowballs", "--frehs", "fuse=balls.mean"])
    assert "--fresh" in capsys.readouterr().err


def test_a_word_too_many_is_told_if_a_command_takes_one(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command_line.main(["check", "a.yaml", "b.yaml"])
    assert "unrecognized arguments: b.yaml" in capsys.readouterr().err
