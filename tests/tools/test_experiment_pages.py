"""The commands and pictures of docs/experiments."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from tests.tools.compared import ROOT, SIMULATED

from followspot.cli.parser import build_parser
from followspot_compare.command import plan_scenes
from followspot_compare.variants import read_variants

PANORAMA = str(ROOT / "graphs/rooms/simulated_panorama.yaml")
PAGES = (ROOT / "docs/experiments.md", *sorted((ROOT / "docs/experiments").glob("*.md")))


def commands() -> list[str]:
    text = "\n".join(page.read_text() for page in PAGES)
    shown = "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL)).replace("\\\n", " ")
    return [line for line in shown.splitlines() if line.startswith("followspot ")]


def test_the_pages_show_commands() -> None:
    assert len(commands()) > 5


@pytest.mark.parametrize("line", commands())
def test_every_command_of_the_pages_is_understood_and_its_variants_can_be_planned(
    line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    words = shlex.split(line)[1:]
    args = build_parser(words).parse_args(words)
    assert callable(args.run_command)
    for path in re.findall(r"graphs/\S+\.(?:yaml|py)", line):
        assert Path(path).is_file()
    if line.startswith("followspot compare "):
        args.rooms = [PANORAMA if "persons.yaml" in line else SIMULATED]
        assert plan_scenes(read_variants(args.graphs, args.variants), args)


def test_every_picture_of_the_pages_is_there() -> None:
    shown = [(page, path) for page in PAGES for path in re.findall(r"!\[.*?\]\((.*?)\)", page.read_text())]
    assert shown
    for page, path in shown:
        assert (page.parent / path).stat().st_size > 5_000
