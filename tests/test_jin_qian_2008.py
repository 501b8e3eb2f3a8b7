"""The page on Jin & Qian 2008 leaves nothing of the paper out, and its commands can be planned."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from tests.test_papers import NONE, rows

from followspot.cli.main import build_parser
from followspot_compare.command import plan_scenes
from followspot_compare.variants import read_variants

ROOT = Path(__file__).parent.parent
ROOM = str(ROOT / "graphs/rooms/simulated.yaml")
PAGE = ROOT / "docs/jin_qian_2008.md"
SECTIONS = ["1", "2", "2.1", "2.2", "3", "3.1", "3.2", "3.3", "3.4", "3.5", "3.6", "3.7", "3.8", "4", "5"]
NUMBERED = [
    *(f"eq. {number}" for number in range(1, 11)),
    *(f"table {number}" for number in range(1, 4)),
    *(f"figure {number}" for number in range(1, 12)),
]


def commands() -> list[str]:
    """Those in blocks and those in the tables."""
    text = PAGE.read_text(encoding="utf-8")
    blocks = "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL)).replace("\\\n", " ")
    shown = [line for line in blocks.splitlines() if line.startswith("followspot ")]
    return list(dict.fromkeys([*shown, *re.findall(r"`(followspot [a-z][^`]+)`", text)]))


def test_every_section_has_its_heading_in_the_order_of_the_paper() -> None:
    assert re.findall(r"^#+ (\d(?:\.\d)*)\.? ", PAGE.read_text(encoding="utf-8"), re.MULTILINE) == SECTIONS


@pytest.mark.parametrize("part", NUMBERED)
def test_every_equation_table_and_figure_has_its_row(part: str) -> None:
    assert any(re.search(rf"\b{re.escape(part)}\b", row["paper"]) for row in rows(PAGE))


def test_what_is_built_is_held_by_a_test() -> None:
    for row in rows(PAGE):
        assert row["code"] == NONE or "::test_" in row["held by"], row["paper"]


@pytest.mark.parametrize("line", commands())
def test_every_command_is_understood_and_its_variants_can_be_planned(line: str) -> None:
    words = shlex.split(line)[1:]
    args = build_parser(words).parse_args(words)
    assert callable(args.run_command)
    if line.startswith("followspot compare "):
        args.graphs, args.rooms = [str(ROOT / graph) for graph in args.graphs], [ROOM]
        assert plan_scenes(read_variants(args.graphs, args.variants), args)


def test_every_picture_is_there() -> None:
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", PAGE.read_text(encoding="utf-8"))
    assert len(pictures) >= 5
    for path in pictures:
        assert (PAGE.parent / path).stat().st_size > 5_000
