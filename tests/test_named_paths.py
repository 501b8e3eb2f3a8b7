"""Every path of this tree that a document names exists, and the page of the tools lists each script."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = (*ROOT.glob("*.md"), ROOT / "tools/README.md", *(ROOT / "docs").rglob("*.md"))
FOLDERS = "core|deploy|docs|graphs|plugins|tests|tools|web"
PATH = re.compile(rf"(?<![\w./-])(?:{FOLDERS})/[\w./@-]*[\w/]")


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_every_path_that_a_page_names_is_there(page: Path) -> None:
    named = set(PATH.findall(page.read_text(encoding="utf-8")))
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []


def test_the_page_of_the_tools_lists_every_script_under_its_folder() -> None:
    listed: dict[str, set[str]] = {"tools": set()}
    folder = "tools"
    for line in (ROOT / "tools/README.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            (below,) = re.findall(r"`(bench/\w+)/`", line) or [""]
            folder = f"tools/{below}".rstrip("/")
        listed.setdefault(folder, set()).update(re.findall(r"`(\w+\.py)`", line))
    folders = [ROOT / "tools", *(ROOT / "tools/bench").iterdir()]
    there = {
        str(path.relative_to(ROOT)): {file.name for file in path.glob("*.py")}
        for path in folders
        if [*path.glob("*.py")]
    }
    assert listed == there
