"""What several files of tests share stands in modules that hold no tests."""

from __future__ import annotations

import re
from pathlib import Path

IMPORT = re.compile(r"^(?:from|import) (tests\.[\w.]*\btest_\w+)", re.MULTILINE)


def test_no_file_of_tests_imports_from_another() -> None:
    folder = Path(__file__).parent
    found = {path.name: IMPORT.findall(path.read_text()) for path in folder.rglob("*.py")}
    assert not {name: modules for name, modules in found.items() if modules}
