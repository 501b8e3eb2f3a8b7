"""Options may stand before, between and after the words of a command."""

from __future__ import annotations

import argparse
from dataclasses import replace

import pytest

from followspot.cli import main as command_line
from followspot.cli import parser as command_parser
from followspot.cli import swap


@pytest.mark.parametrize(
    "words",
    [
        ["--fresh", "--run", "glowballs", "fuse=balls.mean", "color.similarity=0.7"],
        ["--run", "glowballs", "--fresh", "fuse=balls.mean", "color.similarity=0.7"],
        ["fuse=balls.mean", "--fresh", "color.similarity=0.7", "--run", "glowballs", "--json"],
        ["fuse=balls.mean", "color.similarity=0.7", "--fresh", "--run=glowballs"],
    ],
)
def test_options_of_swap_stand_anywhere(words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[argparse.Namespace] = []

    def note(args: argparse.Namespace) -> int:
        """Note what is asked."""
        asked.append(args)
        return 0

    monkeypatch.setattr(
        command_parser, "CORE", (replace(next(one for one in swap.COMMANDS if one.name == "swap"), run=note),)
    )
    assert command_line.main(["swap", *words]) == 0
    assert asked[0].run == "glowballs"
    assert asked[0].words == ["fuse=balls.mean", "color.similarity=0.7"]
    assert asked[0].fresh


def test_a_wrong_option_among_the_words_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command_line.main(["swap", "fuse=balls.mean", "--frehs", "color.similarity=0.7"])
    assert "--fresh" in capsys.readouterr().err


RUN_COMMANDS = {
    *(
        "top",
        "hz",
        "echo",
        "logs",
        "pause",
        "resume",
        "step",
        "mark",
        "save",
        "set",
        "swap",
        "move",
        "attach",
    ),
    "dashboard",
}


def test_every_command_names_its_run_in_the_same_way() -> None:
    known = command_parser.build_parser()._subparsers
    assert known is not None
    (commands,) = known._group_actions
    assert isinstance(commands.choices, dict)
    for name in RUN_COMMANDS:
        actions = {action.dest: action for action in commands.choices[name]._actions}
        assert actions["run"].option_strings == ["--run"], name
        assert not actions["run"].required, name
        assert actions["run"].help is not None, name
        assert actions["run"].help.startswith("which run, if several go on"), name


@pytest.mark.parametrize(
    "words", [["top", "glowballs"], ["mark", "glowballs"], ["move", "a", "b", "glowballs"]]
)
def test_a_run_without_its_option_is_told_the_option(
    capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    with pytest.raises(SystemExit):
        command_line.main(words)
    assert "unrecognized arguments: glowballs; name a run by --run" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["swap", "glowballs", "fuse=balls.mean"], ["dashboard", "glowballs"]])
def test_a_run_in_the_place_of_something_else_is_told_the_option(
    capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    assert command_line.main(words) == 2
    assert "--run glowballs" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["run", "g.yaml", "--room", "a.yaml", "--room", "b.yaml"],
            "--room: given twice, as a.yaml and as b",
        ),
        (["run", "g.yaml", "--out=a", "--frames", "3", "--out", "b"], "--out: given twice, as a and as b"),
        (["run", "g.yaml", "--placement", "camera", "--placement", "stage"], "as camera and as stage"),
        (["run", "g.yaml", "--edges", "auto", "--edges", "ring"], "as auto and as ring"),
        (["run", "g.yaml", "--cameras", "a", "--cameras", "b"], "as a and as b"),
        (["sweep", "g.yaml", "-o", "a", "--out", "b"], "-o/--out: given twice, as a and as b"),
        (["demo", "--frames", "3", "--frames", "4"], "--frames: given twice, as 3 and as 4"),
        (
            ["score", "a.csv", "b.csv", "--between", "1", "2", "--between", "3", "4"],
            "--between: given twice, as 1 2 and as 3 4",
        ),
    ],
)
def test_two_values_of_an_option_that_takes_one_are_refused(
    capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    with pytest.raises(SystemExit) as refused:
        command_line.main(words)
    assert refused.value.code == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["run", "g.yaml", "--out", ""], "--out"),
        (["run", "g.yaml", "--media="], "--media"),
        (["run", "g.yaml", "--certificates", ""], "--certificates"),
        (["graph", "g.yaml", "--svg", ""], "--svg"),
        (["simulate", "--room", "", "--out", "a"], "--room"),
        (["simulate", "--room", "r.yaml", "--out", ""], "--out"),
        (["export", "a.mcap", "", "--to", "csv"], "DIR"),
        (["new", "plugin", "mine", "--dir", ""], "--dir"),
    ],
)
def test_an_empty_path_is_not_the_current_folder(
    capsys: pytest.CaptureFixture[str], words: list[str], named: str
) -> None:
    with pytest.raises(SystemExit) as refused:
        command_line.main(words)
    assert refused.value.code == 2
    said = capsys.readouterr().err
    assert f"{named}: the path is empty" in said


@pytest.mark.parametrize(
    ("option", "needed"),
    [
        ("--router", "endpoint"),
        ("--connect", "endpoint"),
        ("--listen", "endpoint"),
        ("--host", "name"),
        ("--keep-ports", "list of ports"),
        ("--record-ports", "list of ports"),
    ],
)
def test_an_empty_value_is_not_the_default_of_an_option(
    capsys: pytest.CaptureFixture[str], option: str, needed: str
) -> None:
    for words in ([option, ""], [f"{option}="]):
        with pytest.raises(SystemExit) as refused:
            command_line.main(["run", "g.yaml", *words])
        assert refused.value.code == 2
        assert f"{option}: the {needed} is empty" in capsys.readouterr().err


def test_a_note_may_be_empty() -> None:
    assert command_parser.build_parser().parse_args(["mark", "--note", ""]).note == ""


def test_an_option_may_say_the_same_twice_and_be_another_in_the_next_command() -> None:
    words = ["run", "g.yaml", "--frames", "3", "--frames=3", "--connect", "tcp/a:1", "--connect", "tcp/b:1"]
    parser = command_parser.build_parser()
    assert parser.parse_args(words).connect == ["tcp/a:1", "tcp/b:1"]
    assert parser.parse_args([*words[:2], "--frames", "4"]).frames == 4


def test_a_word_too_many_is_told_if_a_command_takes_one(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command_line.main(["check", "a.yaml", "b.yaml"])
    assert "unrecognized arguments: b.yaml" in capsys.readouterr().err
