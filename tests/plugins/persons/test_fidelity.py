"""The page that says where the paper is held names tests that exist."""

import re
from pathlib import Path

HERE = Path(__file__).parent
PAGE = (HERE.parents[2] / "docs/detection.md").read_text(encoding="utf-8")


def test_every_test_that_the_page_names_exists():
    written = "\n".join(file.read_text(encoding="utf-8") for file in HERE.glob("test_*.py"))
    named = set(re.findall(r"`(test_\w+)`", PAGE))
    assert len(named) >= 15
    assert not {name for name in named if f"def {name}(" not in written}
