"""Errors and warnings that scripts get name keywords of `run`, not options of the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.core.library.scripts import TICKS, endless

import followspot as fs
from followspot.errors import FollowspotError, InputError
from followspot.library.keywords import in_python


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    path = tmp_path / "graph.yaml"
    path.write_text("graph: g\nstages: {a: {uses: ticks.count}, b: {uses: ticks.tally, in: {number: a}}}\n")
    return path


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("choose another with --out", "choose another with out="),
        ("check the path, or use --room FILE", "check the path, or use room=FILE"),
        ("leave them out: --cameras cam0,cam3", "leave them out: cameras=['cam0', 'cam3']"),
        (
            "a smaller one (--set a.t=0.1 --set b/c.t=2), or",
            'a smaller one (set={"a.t": 0.1, "b/c.t": 2}), or',
        ),
        ("--plugin: low.py cannot be read", "plugin_files: low.py cannot be read"),
        ("raise ulimit -n 4096, or --placement", "raise ulimit -n 4096, or placement="),
        ("name it here with --connect", "name it here with network=Network(connect=...)"),
        (
            "begun with --listen or --router",
            "begun with network=Network(listen=...) or network=Network(router=...)",
        ),
        (
            "followspot run GRAPH --frames 200 > report.json, then --placement auto:report.json",
            'followspot run GRAPH --frames 200 > report.json, then placement="auto:report.json"',
        ),
        ("a run with --placement camera: stop it", 'a run with placement="camera": stop it'),
        ("`followspot run GRAPH --placement camera`", "`followspot run GRAPH --placement camera`"),
        ("write to --record-ports or --outer", "write to --record-ports or --outer"),
    ],
)
def test_keywords_stand_for_options_and_commands_stay(text: str, expected: str) -> None:
    assert in_python(text) == expected


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"set": {"nope.x": 1}}, "set:1:1: the graph has no stage"),
        ({"room": "nope.yaml"}, "or use room=FILE"),
        ({"placement": "nope"}, "placement:1:1: cannot read nope"),
        ({"plugin_files": ["nope.py"]}, "plugin_files: "),
    ],
)
def test_mistakes_in_the_options_of_a_run_name_its_keywords(
    graph: Path, options: dict[str, Any], words: str
) -> None:
    with pytest.raises(InputError) as caught:
        fs.run(graph, **{"plugin_files": [TICKS], **options})
    assert words in str(caught.value)
    assert "--" not in str(caught.value)
    (told, *_) = fs.check(graph, **{"plugin_files": [TICKS], **options})
    assert words in str(told)


def test_settings_that_are_no_mapping_are_told(graph: Path) -> None:
    option: Any = "b.term=2"
    (mistake,) = fs.check(graph, set=option, plugin_files=[TICKS])
    assert (mistake.text, mistake.remedy.split()[0:3]) == ("set is 'b.term=2'", ["give", "a", "mapping,"])


def test_a_folder_that_cannot_be_made_is_told_with_its_remedy(graph: Path) -> None:
    with pytest.raises(FollowspotError, match=r"cannot make the output folder .*; choose one with out="):
        fs.run(graph, out=graph / "below", plugin_files=[TICKS])


def test_a_folder_in_use_and_a_mark_without_a_recorder_name_keywords(tmp_path: Path) -> None:
    with endless(tmp_path) as run:
        with pytest.raises(FollowspotError, match="choose another with out="), endless(tmp_path):
            pass
        with pytest.raises(FollowspotError, match='start it with keep="30s"'):
            run.mark()
