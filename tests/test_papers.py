"""The pages that hold the papers line by line name code, tests, graphs and commands that exist."""

from __future__ import annotations

import re
import shlex
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from followspot.cli.main import build_parser

ROOT = Path(__file__).parent.parent
PAGES = [page for name in ("jin_qian_2008", "weinrich_2010") if (page := ROOT / f"docs/{name}.md").is_file()]
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
