"""Each table below a command of the pages about speed is what a tool prints that takes these options."""

from __future__ import annotations

import importlib
import re
import subprocess
from pathlib import Path

import pytest

import speed_page

PAGES = speed_page.pages()
BLOCKS = list(speed_page.blocks(PAGES))
RUNTIME = ("busy_machine", "edges", "forecast_delay", "hop_code", "live_latency", "peers", "scaling", "start")
TOOLS = {
    *("bench_tracker", "bench/runtime/tracker_calls", "speed_page"),
    *(f"bench/runtime/{name}" for name in RUNTIME),
}


@pytest.mark.parametrize("block", BLOCKS, ids=[block.command for block in BLOCKS])
def test_the_command_of_each_table_takes_its_options(block: speed_page.Block) -> None:
    assert (speed_page.ROOT / f"tools/{block.tool}.py").is_file()
    importlib.import_module(block.tool.replace("/", ".")).parser().parse_args([*block.options, "--markdown"])


def test_all_tools_of_the_pages_print_tables_there() -> None:
    assert {block.tool for block in BLOCKS} == TOOLS
    assert len({block.command for block in BLOCKS}) == len(BLOCKS)


def test_only_the_tables_below_a_command_are_replaced() -> None:
    page = "a\n\n```sh\npython tools/x.py --n 1    # why\n```\n\n| a |\n| --- |\n| 1 |\n\n| b |\n\nb\n| c |\n"
    (block,) = speed_page.blocks(page)
    assert (block.tool, block.options) == ("x", ["--n", "1"])
    made = speed_page.rewritten(page, block.command, "\n| d |\n| --- |\n\n")
    assert made == "a\n\n```sh\npython tools/x.py --n 1    # why\n```\n\n| d |\n| --- |\n\nb\n| c |\n"
    assert list(speed_page.blocks("```sh\npython tools/x.py\n```\n\nwords\n\n| a |\n")) == []


def test_tables_are_replaced_on_the_page_that_has_their_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    both = [tmp_path / "first.md", tmp_path / "second.md"]
    for page, tool in zip(both, "xy", strict=True):
        page.write_text(f"```sh\npython tools/{tool}.py\n```\n\n| old |\n")
    monkeypatch.setattr(speed_page, "PAGES", both)
    speed_page.rewrite("python tools/y.py", "| new |")
    assert [page.read_text().splitlines()[-1] for page in both] == ["| old |", "| new |"]


def test_commands_with_a_room_of_the_reader_wait_for_one() -> None:
    block = next(block for block in BLOCKS if block.tool == "bench_tracker")
    parse = speed_page.parser().parse_args
    assert not speed_page.wanted(block, parse([]))
    assert speed_page.wanted(block, parse(["--rooms", "mine"]))
    assert not speed_page.wanted(block, parse(["--rooms", "mine", "--only", "bench/runtime/edges"]))


def test_rooms_of_the_page_are_those_of_the_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ran: list[list[str]] = []

    def run(words: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        ran.append(words)
        return subprocess.CompletedProcess(words, 0, "| a |")

    monkeypatch.setattr(subprocess, "run", run)
    speed_page.printed("python tools/x.py --room dev1.yaml --room dev6.yaml", tmp_path)
    assert ran[0][3::2] == [str(tmp_path / "dev1.yaml"), str(tmp_path / "dev6.yaml")]


def test_the_aims_are_held_against_the_tables_of_the_pages() -> None:
    (block,) = (block for block in BLOCKS if block.command == speed_page.AIMS)
    assert PAGES[block.begin : block.end].strip() == speed_page.aims(PAGES)


def test_an_aim_is_held_or_missed_by_its_figure() -> None:
    (block,) = (block for block in BLOCKS if block.tool == "bench_tracker")
    rate = PAGES[block.begin : block.end].split("\n")[2].split("|")[2]
    faster = PAGES.replace(f"| tracked |{rate}|", "| tracked | 801 |")
    assert "| frame sets/s tracked | at least 800 | 801 | yes |" in speed_page.aims(faster)
    assert "| frame sets/s tracked | at least 800 | 801 | yes |" not in speed_page.aims(PAGES)
    with pytest.raises(LookupError, match="bench/runtime/start printed no a worker more of forked"):
        speed_page.aims(PAGES.replace("| forked |", "| spooned |"))


def test_the_words_of_the_pages_repeat_no_figure_that_was_measured() -> None:
    """Those of the tables change whenever these are printed anew."""
    words = re.sub(r"```.*?```|`[^`]*`|^\|[^\n]*$", "", PAGES, flags=re.MULTILINE | re.DOTALL)
    allowed = {"0.5 ms", "2.2 GB", "2 %"}  # an aim; bytes of the pictures; width of a histogram's bin
    found = set(re.findall(r"\d[\d.,]*(?: to \d[\d.,]*)? (?:us|ms|s|%|MB|GB|times|frame sets)\b|\d %", words))
    assert found - allowed == set()
