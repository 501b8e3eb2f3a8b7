"""The pages that hold the papers line by line leave nothing out, and name what exists and can be run."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from followspot.cli.parser import build_parser
from followspot_compare.command import plan_scenes
from followspot_compare.variants import read_variants

ROOT = Path(__file__).parent.parent


@dataclass(frozen=True)
class Paper:
    """What a page has of its paper; pictures: at least; room: in which its comparisons are planned."""

    room: str
    sections: tuple[str, ...]
    numbered: tuple[str, ...]
    pictures: int = 0


def counted(**most: int) -> tuple[str, ...]:
    """Such as eq. 1, eq. 2."""
    return tuple(
        f"{word.replace('eq', 'eq.')} {n}" for word, count in most.items() for n in range(1, count + 1)
    )


PAPERS = {
    ROOT / "docs/jin_qian_2008.md": Paper(
        "graphs/rooms/simulated.yaml",
        ("1", "2", "2.1", "2.2", "3", *(f"3.{n}" for n in range(1, 9)), "4", "5"),
        counted(eq=10, table=3, figure=11),
        5,
    ),
    ROOT / "docs/weinrich_2010.md": Paper(
        "graphs/rooms/simulated_panorama.yaml",
        ("3", "3.1", "3.2", "3.3", "3.4", "4", "5", "6"),
        (*counted(eq=7, figure=6), "line 2", "lines 3 to 6", "line 8"),  # lines of algorithm 1
    ),
}
PAGES = list(PAPERS)
HEAD = ["paper", "code", "held by", "experiment", "deviation and its effect"]
NONE = "none"
"""What stands in a cell if there is nothing."""
MISSING, WHOLE = "**missing**", "whole"
"""How the deviation begins where nothing of a line is built, and where nothing deviates."""


def rows(page: Path) -> list[dict[str, str]]:
    """The rows of all tables with the columns of `HEAD`."""
    found, wanted = [], False
    for line in page.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if not line.startswith("|"):
            wanted = False
        elif cells == HEAD:
            wanted = True
        elif wanted and not set(line) <= set("|-: "):
            assert len(cells) == len(HEAD), f"{page.name}: a row has {len(cells)} cells: {line}"
            found.append(dict(zip(HEAD, cells, strict=True)))
    return found


CASES = [pytest.param(page, row, id=f"{page.stem}-{n}") for page in PAGES for n, row in enumerate(rows(page))]


def named(cell: str, pattern: str) -> list[str]:
    """What stands in backticks in a cell and has this form."""
    return [text for text in re.findall(r"`([^`]+)`", cell) if re.fullmatch(pattern, text)]


def resolved(name: str) -> object:
    """The module, class, function or constant of a dotted name."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            thing: object = import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            thing = getattr(thing, part)
        return thing
    raise ModuleNotFoundError(name)


@cache
def source(file: str) -> str:
    return (ROOT / file).read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_paper_is_held_by_many_rows(page: Path) -> None:
    assert len(rows(page)) >= 25


@pytest.mark.parametrize(("page", "row"), CASES)
def test_what_a_row_names_exists(page: Path, row: dict[str, str]) -> None:
    assert all(row.values()), f"{page.name}: an empty cell; write {NONE}"
    code = named(row["code"], r"followspot\w*(\.\w+)+")
    tests = named(row["held by"], r"tests/\S+::\w+")
    files = named(" ".join(row.values()), r"(graphs|tools|docs|tests)/[\w/.-]+\.\w+")
    for name in code:
        resolved(name)
    for test in tests:
        file, _, name = test.partition("::")
        assert f"def {name}(" in source(file), f"{page.name}: {test} is not there"
    for file in files:
        assert (ROOT / file).is_file(), f"{page.name}: {file} is not there"
    for command in named(row["experiment"], r"followspot .*"):
        build_parser().parse_args(shlex.split(command)[1:])


@pytest.mark.parametrize(("page", "row"), CASES)
def test_what_is_said_to_be_whole_is_held_and_what_is_missing_has_no_code(
    page: Path, row: dict[str, str]
) -> None:
    code = named(row["code"], r"(followspot\w*(\.\w+)+|graphs/\S+)")
    tests = named(row["held by"], r"tests/\S+::\w+")
    missing = row["deviation and its effect"].startswith(MISSING)
    assert (row["code"] == NONE) == missing, f"{page.name}: code or {MISSING}, not both: {row['paper']}"
    assert bool(code) != missing, f"{page.name}: name the code of: {row['paper']}"
    if row["deviation and its effect"].startswith(WHOLE):
        assert tests, f"{page.name}: nothing holds what is said to be whole: {row['paper']}"
    if row["held by"] != NONE:
        assert tests, f"{page.name}: name tests as file::test, or {NONE}: {row['paper']}"


def commands(page: Path) -> list[str]:
    """Those in blocks and the experiments of the tables."""
    text = page.read_text(encoding="utf-8")
    blocks = "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL)).replace("\\\n", " ")
    shown = [line for line in blocks.splitlines() if line.startswith("followspot ")]
    experiments = [line for row in rows(page) for line in named(row["experiment"], r"followspot [a-z].*")]
    return list(dict.fromkeys([*shown, *experiments]))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_section_has_its_heading_in_the_order_of_the_paper(page: Path) -> None:
    headings = re.findall(r"^#+ (\d(?:\.\d)*)\.? ", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert tuple(headings) == PAPERS[page].sections


@pytest.mark.parametrize(("page", "part"), [(page, part) for page in PAGES for part in PAPERS[page].numbered])
def test_every_equation_table_and_figure_has_its_row(page: Path, part: str) -> None:
    assert any(re.search(rf"\b{re.escape(part)}\b", row["paper"]) for row in rows(page))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_is_built_is_held_by_a_test(page: Path) -> None:
    for row in rows(page):
        assert row["code"] == NONE or "::test_" in row["held by"] or ".py`" in row["held by"], row["paper"]


@pytest.mark.parametrize(("page", "line"), [(page, line) for page in PAGES for line in commands(page)])
def test_every_command_is_understood_and_its_variants_can_be_planned(page: Path, line: str) -> None:
    words = shlex.split(line)[1:]
    args = build_parser(words).parse_args(words)
    assert callable(args.run_command)
    if line.startswith("followspot compare "):
        args.graphs, args.rooms = (
            [str(ROOT / graph) for graph in args.graphs],
            [str(ROOT / PAPERS[page].room)],
        )
        assert plan_scenes(read_variants(args.graphs, args.variants), args)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_picture_is_there(page: Path) -> None:
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", page.read_text(encoding="utf-8"))
    assert len(pictures) >= PAPERS[page].pictures
    for picture in pictures:
        assert (page.parent / picture).stat().st_size > 5_000
