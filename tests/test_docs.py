"""The documents are true: their commands exist, their Python runs, their stages take what is shown."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import msgpack
import numpy as np
import pytest
import yaml

from followspot.cli.main import build_parser
from followspot.plugins.registry import load_stage
from followspot.tracking import Blobs
from followspot.transport.codec import pack

ROOT = Path(__file__).parent.parent
PAGES = {page.name: page.read_text() for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))}
FENCED = re.compile(r"^```(?P<language>\S*)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE)


def blocks(page: str, language: str) -> list[str]:
    return [found["text"] for found in FENCED.finditer(PAGES[page]) if found["language"] == language]


def commands() -> list[tuple[str, str]]:
    """Every followspot command of every page, with continued lines joined."""
    found = []
    for page in PAGES:
        for block in (*blocks(page, "sh"), *blocks(page, "")):
            lines = [line.split(" #")[0].strip() for line in block.replace("\\\n", " ").splitlines()]
            found += [(page, line) for line in lines if line.startswith("followspot ")]
    return found


@pytest.mark.parametrize(("page", "line"), commands())
def test_every_command_shown_is_understood(page: str, line: str) -> None:
    args = build_parser().parse_args(shlex.split(line)[1:])
    assert callable(args.run_command)
    for path in re.findall(r"(?:graphs|docs|tools)/[\w./-]+\.\w+", line):
        assert (ROOT / path).is_file(), path


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "yaml")])
def test_every_stage_shown_takes_the_parameters_shown(page: str) -> None:
    for block in blocks(page, "yaml"):
        shown = yaml.safe_load(block)
        for name, declared in (shown.get("stages") or shown).items():
            stage = declared["uses"] if isinstance(declared, dict) and "uses" in declared else "room.source"
            if stage.startswith(("room.", "studio.", "low.")) or "..." in str(declared):
                continue
            assert load_stage(stage)(**declared.get("with", {})), name


def test_the_decoder_of_the_wire_format_decodes() -> None:
    (recipe,) = blocks("wire.md", "python")
    message = Blobs.empty()
    known = {"data": pack(message), "arrays": {}, "np": np, "msgpack": msgpack}
    exec("import math\n" + recipe, known)  # the page's own words
    assert known["name"] == "Blobs"
    for column, values in known["arrays"].items():  # type: ignore[attr-defined]
        np.testing.assert_array_equal(values, getattr(message, column))


def test_the_tests_shown_to_authors_of_plugins_are_green(tmp_path: Path) -> None:
    package = tmp_path / "followspot_mine"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "low.py").write_text(f'"""Keep what is low."""\n\n{blocks("README.md", "python")[0]}')
    (tmp_path / "test_low.py").write_text("\n\n".join(blocks("plugins.md", "python")))
    words = [sys.executable, "-m", "pytest", "-q", "--import-mode=prepend", tmp_path]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "2 passed" in done.stdout, done.stdout + done.stderr


def test_the_reference_describes_the_stages_as_they_are() -> None:
    script = [sys.executable, ROOT / "tools" / "reference.py", "--check"]
    assert subprocess.run(script, check=False).returncode == 0, "stale: run python tools/reference.py"


@pytest.mark.parametrize("page", PAGES)
def test_every_page_that_is_linked_is_there(page: str) -> None:
    for target in re.findall(r"\]\(([\w./-]+)(?:#[\w-]+)?\)", PAGES[page]):
        folder = ROOT if page == "README.md" else ROOT / "docs"
        assert (folder / target).is_file(), target
