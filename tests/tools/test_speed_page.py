"""Each table of docs/speed.md below a command is what a tool prints that exists and takes its options."""

from __future__ import annotations

import importlib

import pytest

import speed_page

PAGE = speed_page.PAGE.read_text()
BLOCKS = list(speed_page.blocks(PAGE))
TOOLS = {
    *("bench_tracker", "bench_edges", "bench_hop_code", "bench_live", "bench_peers", "bench_delay"),
    *("bench_beside", "bench_cost", "bench_start", "speed_page"),
}


@pytest.mark.parametrize("block", BLOCKS, ids=[block.command for block in BLOCKS])
def test_the_command_of_each_table_takes_its_options(block: speed_page.Block) -> None:
    assert (speed_page.ROOT / f"tools/{block.tool}.py").is_file()
    importlib.import_module(block.tool).parser().parse_args([*block.options, "--markdown"])


def test_all_tools_of_the_page_print_tables_there() -> None:
    assert {block.tool for block in BLOCKS} == TOOLS
    assert len({block.command for block in BLOCKS}) == len(BLOCKS)


def test_only_the_tables_below_a_command_are_replaced() -> None:
    page = "a\n\n```sh\npython tools/x.py --n 1    # why\n```\n\n| a |\n| --- |\n| 1 |\n\n| b |\n\nb\n| c |\n"
    (block,) = speed_page.blocks(page)
    assert (block.tool, block.options) == ("x", ["--n", "1"])
    made = speed_page.rewritten(page, block.command, "\n| d |\n| --- |\n\n")
    assert made == "a\n\n```sh\npython tools/x.py --n 1    # why\n```\n\n| d |\n| --- |\n\nb\n| c |\n"
    assert list(speed_page.blocks("```sh\npython tools/x.py\n```\n\nwords\n\n| a |\n")) == []


def test_commands_with_a_room_of_the_reader_wait_for_one() -> None:
    block = next(block for block in BLOCKS if block.tool == "bench_tracker")
    parse = speed_page.parser().parse_args
    assert not speed_page.wanted(block, parse([]))
    assert speed_page.wanted(block, parse(["--room", "mine.yaml"]))
    assert not speed_page.wanted(block, parse(["--room", "mine.yaml", "--only", "bench_edges"]))
